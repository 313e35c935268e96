"""Forward pass: the trajectory of changed accelerations and durations, and what it costs (docs/bounces.md)."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.reflection import reflect
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at, normal_at
from collplan_core.time_to_goal_planner.model import Constants, Problem
from collplan_core.time_to_goal_planner.smoothing.knots import AX, ONE, TAU, Gains, Knots
from collplan_core.velocity_bounds import VelocityBounds

EFFORT = 1e-4
"""Weight of the square of an acceleration: of equally fast plans the calm one [s^4/m^2]."""
ACCELERATION, SPEED = 20.0, 20.0
"""Weights of the squares by which acceleration and speed exceed their limits [s^4/m^2, s^2/m^2]."""
OFF_WALL, OFF_SPEED, OFF_GOAL = 1500.0, 100.0, 500.0
"""Weights of the squares by which a contact is off its boundary and off the speeds it may have, and the end is off the
goal's disc [s/m^2, s^3/m^2, s/m^2]."""
SLOWER = 0.8
"""Share of the speed that counts as rest at the goal, smoothed for: the penalty alone ends a little above it."""
SLOWEST_CONTACT = 0.1
"""Slowest contact smoothed for: a slower one soon is none [m/s]."""
ACCELERATION_SHARE, MORE_LAG = 0.98, 0.04
"""Share of the largest acceleration, and time beyond the lag by which a command leads the velocity [s], that commands
which hold for an interval can follow."""


class Term(NamedTuple):
    """A function of two variables at a place: its value, gradient (gx, gy) and Hessian (hxx, hxy, hyy)."""

    value: float
    gx: float
    gy: float
    hxx: float
    hxy: float
    hyy: float


NONE = Term(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Stage(NamedTuple):
    """The cost of a moment by time: terms of the place, of v + lag a, and of the acceleration; their sum and 1."""

    place: Term
    lead: Term
    acceleration: Term
    rate: float


@njit
def beyond(weight: float, x: float, y: float, limit: float) -> Term:
    """weight [|(x, y)| - limit]_+^2."""
    length = math.sqrt(x * x + y * y)
    if length <= limit:
        return NONE
    over, twice, ex, ey = length - limit, 2.0 * weight, x / length, y / length
    across = over / length
    hxx, hxy, hyy = ex * ex + across * ey * ey, (1.0 - across) * ex * ey, ey * ey + across * ex * ex
    return Term(weight * over * over, twice * over * ex, twice * over * ey, twice * hxx, twice * hxy, twice * hyy)


@njit
def off(weight: float, error: float, nx: float, ny: float) -> Term:
    """weight error^2 of an error that grows along n: exact to the gradient, Gauss-Newton's Hessian."""
    g, twice = 2.0 * weight * error, 2.0 * weight
    return Term(weight * error * error, g * nx, g * ny, twice * nx * nx, twice * nx * ny, twice * ny * ny)


@njit
def too_fast(weight: float, x: float, y: float, bounds: VelocityBounds) -> Term:
    """weight times the square by which a velocity is beyond its bounds, of a box by each axis."""
    if not bounds.is_box:
        return beyond(weight, x, y, bounds.max_speed)
    c, s, most = bounds.cos, bounds.sin, bounds.max_speed
    ahead, left = c * x + s * y, c * y - s * x
    over_x, over_y = ahead - min(max(ahead, -most), most), left - min(max(left, -most), most)
    one = off(weight if over_x != 0.0 else 0.0, over_x, c, s)
    two = off(weight if over_y != 0.0 else 0.0, over_y, -s, c)
    gx, gy = one.gx + two.gx, one.gy + two.gy
    return Term(one.value + two.value, gx, gy, one.hxx + two.hxx, one.hxy + two.hxy, one.hyy + two.hyy)


@njit
def plus(one: Term, value: float, gx: float, gy: float, curvature: float) -> Term:
    """A term and another one, which bends alike in all directions."""
    hxx, hyy = one.hxx + curvature, one.hyy + curvature
    return Term(one.value + value, one.gx + gx, one.gy + gy, hxx, one.hxy, hyy)


@njit
def stage(clearance: np.ndarray, constants: Constants, margin: float, state: np.ndarray, ax: float, ay: float) -> Stage:
    """The cost of a moment in a state (4,) under acceleration a."""
    grid, model, costs = constants.grid, constants.model, constants.costs
    x, y, lag, place = state[0], state[1], model.wheels.lag + MORE_LAG, NONE
    within = margin - clearance_at(clearance, grid, x, y)
    if within > 0.0:
        nx, ny = normal_at(clearance, grid, x, y)
        place = off(costs.near, -within, nx, ny)
    lead = too_fast(SPEED, state[2] + lag * ax, state[3] + lag * ay, constants.bounds)
    over = beyond(ACCELERATION, ax, ay, ACCELERATION_SHARE * model.wheels.max_acceleration)
    effort = plus(over, EFFORT * (ax * ax + ay * ay), 2.0 * EFFORT * ax, 2.0 * EFFORT * ay, 2.0 * EFFORT)
    return Stage(place, lead, effort, 1.0 + place.value + lead.value + effort.value)


@njit
def contact_terms(
    constants: Constants, distance: float, nx: float, ny: float, vx: float, vy: float
) -> tuple[Term, Term]:
    """Terms of a contact by place and by the velocity before it: at the boundary, neither too slow nor too hard."""
    costs, speed = constants.costs, -(vx * nx + vy * ny)
    within = min(max(speed, SLOWEST_CONTACT), max(costs.limit, SLOWEST_CONTACT))
    hit, cost = off(OFF_SPEED if within != speed else 0.0, within - speed, nx, ny), costs.by_speed
    return off(OFF_WALL, distance, nx, ny), plus(hit, cost * speed, -cost * nx, -cost * ny, 0.0)


MOST_CHANGE = 0.2
"""Largest change of a duration in one pass, as a share of it."""


@njit
def forward(problem: Problem, old: Knots, gains: Gains, share: float, new: Knots) -> float:
    """Writes the trajectory that `share` of what the gains ask for leads to into `new`; its cost [s]."""
    clearance, constants, n = problem.clearance, problem.constants, old.ends[-1]
    grid, goal = constants.grid, constants.goal
    new.states[0] = old.states[0]
    change, phase, first, cost = np.zeros(8), 0, 0, 0.0
    change[ONE] = share
    for k in range(n):
        state, after = new.states[k], new.states[k + 1]
        for c in range(TAU):
            change[c] = state[c] - old.states[k, c]
        if k == first:
            most = MOST_CHANGE * old.durations[phase]
            change[TAU] = min(max(_asked(gains.durations[phase], change), -most), most)
            new.durations[phase] = old.durations[phase] + change[TAU]
        for r in range(2):
            change[AX + r] = _asked(gains.accelerations[k, r], change)
            new.accelerations[k, r] = old.accelerations[k, r] + change[AX + r]
        tau, (ax, ay) = new.durations[phase], new.accelerations[k]
        cost += tau * stage(clearance, constants, old.margins[k], state, ax, ay).rate
        x, y = state[0] + tau * (state[2] + 0.5 * tau * ax), state[1] + tau * (state[3] + 0.5 * tau * ay)
        vx, vy = state[2] + tau * ax, state[3] + tau * ay
        if k + 1 == old.ends[phase] < n:
            nx, ny = normal_at(clearance, grid, x, y)
            place, hit = contact_terms(constants, clearance_at(clearance, grid, x, y), nx, ny, vx, vy)
            cost += place.value + hit.value
            vx, vy, _ = reflect(vx, vy, 0.0, nx, ny, constants.model.ring)
            phase, first = phase + 1, k + 1
        after[0], after[1], after[2], after[3] = x, y, vx, vy
    x, y, vx, vy = new.states[n]
    end = beyond(OFF_GOAL, x - goal.x, y - goal.y, goal.tolerance).value
    return cost + end + beyond(OFF_SPEED, vx, vy, SLOWER * goal.rest_speed).value


@njit
def _asked(gain: np.ndarray, change: np.ndarray) -> float:
    """Change that a gain asks for, given the changes of the other variables."""
    asked = 0.0
    for c in range(len(gain)):
        asked += gain[c] * change[c]
    return asked
