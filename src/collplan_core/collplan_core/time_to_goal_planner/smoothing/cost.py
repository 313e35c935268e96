"""What smoothing minimises, as in docs/bounces.md: each term with its derivatives, written once."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import Grid, clearance_at, normal_at
from collplan_core.time_to_goal_planner.model import Constants

EFFORT = 1e-4
"""Weight of the square of an acceleration: of equally fast plans the calm one [s^4/m^2]."""
ACCELERATION, SPEED = 20.0, 20.0
"""Weights of the squares by which acceleration and speed are exceeded [s^4/m^2, s^2/m^2]."""
OFF_WALL, OFF_SPEED, OFF_GOAL = 1500.0, 100.0, 500.0
"""Weights of the squares by which a contact is off its boundary and off the speeds it may have, and the end is off the
goal's disc [s/m^2, s^3/m^2, s/m^2]."""
SLOWEST_CONTACT = 0.1
"""Slowest contact smoothed for: a slower one soon is none [m/s]."""
ACCELERATION_SHARE, MORE_LAG = 0.98, 0.04
"""Share of the largest acceleration that is planned with, and time beyond the lag by which a command leads the velocity
[s]: what commands that hold for an interval can follow."""


class Term(NamedTuple):
    """A function of two variables at a place: value, gradient (gx, gy) and Hessian (hxx, hxy, hyy)."""

    value: float
    gx: float
    gy: float
    hxx: float
    hxy: float
    hyy: float


NONE = Term(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Limits(NamedTuple):
    """What a smooth plan keeps to, and what contacts and nearness cost, as in ContactCosts.

    Attributes:
        acceleration: [m/s^2]; speed: of v + lag a [m/s]; lag: [s].
        contact_speed: highest speed of a contact [m/s]; contact_cost: by it [s per m/s].
        near: cost by time and square [1/m^2].
    """

    acceleration: float
    speed: float
    lag: float
    contact_speed: float
    contact_cost: float
    near: float


class Stage(NamedTuple):
    """The terms of a moment by place, by v + lag a, and by acceleration."""

    place: Term
    speed: Term
    acceleration: Term


@njit
def limits_of(constants: Constants) -> Limits:
    """The limits of a robot, a little within what it can do; contacts cost by their speed as in rollouts."""
    model, costs = constants.model, constants.costs
    wheels = model.wheels
    acceleration, lag = ACCELERATION_SHARE * wheels.max_acceleration, wheels.lag + MORE_LAG
    return Limits(acceleration, model.max_speed, lag, max(costs.limit, SLOWEST_CONTACT), costs.by_speed, costs.near)


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
def plus(one: Term, other: Term) -> Term:
    """The sum of two terms of the same variables."""
    gx, gy = one.gx + other.gx, one.gy + other.gy
    return Term(one.value + other.value, gx, gy, one.hxx + other.hxx, one.hxy + other.hxy, one.hyy + other.hyy)


@njit
def near(clearance: np.ndarray, grid: Grid, weight: float, margin: float, x: float, y: float) -> Term:
    """weight [margin - clearance]_+^2."""
    error = clearance_at(clearance, grid, x, y) - margin
    if error >= 0.0:
        return NONE
    nx, ny = normal_at(clearance, grid, x, y)
    return off(weight, error, nx, ny)


@njit
def stage(
    clearance: np.ndarray, grid: Grid, limits: Limits, margin: float, state: np.ndarray, ax: float, ay: float
) -> Stage:
    """The terms of a moment in a state (4,) under acceleration a."""
    over, twice = beyond(ACCELERATION, ax, ay, limits.acceleration), 2.0 * EFFORT
    effort = plus(over, Term(EFFORT * (ax * ax + ay * ay), twice * ax, twice * ay, twice, 0.0, twice))
    lead_x, lead_y = state[2] + limits.lag * ax, state[3] + limits.lag * ay
    return Stage(
        near(clearance, grid, limits.near, margin, state[0], state[1]),
        beyond(SPEED, lead_x, lead_y, limits.speed),
        effort,
    )


@njit
def rate(terms: Stage) -> float:
    """Cost by time: the time itself, and what is exceeded."""
    return 1.0 + terms.place.value + terms.speed.value + terms.acceleration.value


@njit
def contact_terms(limits: Limits, distance: float, nx: float, ny: float, vx: float, vy: float) -> tuple[Term, Term]:
    """Terms of a contact by place and by the velocity before it: at the boundary, and neither too slow nor too hard."""
    speed = -(vx * nx + vy * ny)
    within = min(max(speed, SLOWEST_CONTACT), limits.contact_speed)
    outside = off(OFF_SPEED if within != speed else 0.0, within - speed, nx, ny)
    cost = limits.contact_cost
    return off(OFF_WALL, distance, nx, ny), plus(outside, Term(cost * speed, -cost * nx, -cost * ny, 0.0, 0.0, 0.0))
