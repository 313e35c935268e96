"""Backward pass: from the quadratic model of the cost to go at each knot to what changes of the trajectory lower it.

A model is a symmetric matrix over changes of x, y, vx, vy, the duration, 1, and the acceleration of one step. Half its
product with these from both sides is the change of the cost; its row ONE holds the gradient.
"""

import numpy as np

from collplan_core.jit import njit
from collplan_core.reflection import rebound_slope
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at, normal_at
from collplan_core.time_to_goal_planner.model import Problem
from collplan_core.time_to_goal_planner.smoothing.forward import (
    MORE_LAG,
    MOST_CHANGE,
    OFF_GOAL,
    OFF_SPEED,
    SLOWER,
    Term,
    beyond,
    contact_terms,
    stage,
)
from collplan_core.time_to_goal_planner.smoothing.knots import AX, ONE, TAU, VX, Gains, Knots, X

LEAST_CURVATURE = 1e-3
"""Added to the second derivative by a duration [1/s]."""


@njit
def backward(problem: Problem, knots: Knots, damping: float, gains: Gains) -> float:
    """Writes gains that lower the cost of a trajectory; its slope by the share taken of them, twice what they promise.

    Damping is added to the second derivative by accelerations [s^5/m^2].
    """
    states, goal, lag = knots.states, problem.constants.goal, problem.constants.model.wheels.lag + MORE_LAG
    model, half, phase, n = np.zeros((8, 8)), np.zeros((8, 8)), len(knots.ends) - 1, knots.ends[-1]
    _add(model, beyond(OFF_GOAL, states[n, 0] - goal.x, states[n, 1] - goal.y, goal.tolerance), X, 0.0, 1.0, 0.0)
    _add(model, beyond(OFF_SPEED, states[n, 2], states[n, 3], SLOWER * goal.rest_speed), VX, 0.0, 1.0, 0.0)
    for k in range(n - 1, -1, -1):
        tau, (ax, ay) = knots.durations[phase], knots.accelerations[k]
        cost = stage(problem.clearance, problem.constants, knots.margins[k], states[k], ax, ay)
        wx, wy = states[k, 2] + tau * ax, states[k, 3] + tau * ay
        _times_step(model, half, 6, wx, wy, ax, ay, tau)
        _times_step(half.T, model, 8, wx, wy, ax, ay, tau)
        _add(model, cost.place, X, 0.0, tau, 1.0)
        _add(model, cost.lead, VX, lag, tau, 1.0)
        _add(model, cost.acceleration, AX, 0.0, tau, 1.0)
        model[TAU, ONE] += cost.rate
        model[ONE, TAU] += cost.rate
        for r in (1, 0):
            _choose(model, AX + r, damping, np.inf, gains.accelerations[k, r])
        if k == (knots.ends[phase - 1] if phase > 0 else 0):
            _choose(model, TAU, LEAST_CURVATURE, MOST_CHANGE * tau, gains.durations[phase])
            phase -= 1
            if phase >= 0:
                _through_contact(problem, knots, k, phase, model)
    return model[ONE, ONE]


@njit
def _add(model: np.ndarray, term: Term, i: int, lead: float, tau: float, by_tau: float) -> None:
    """Adds tau times a term of the variables i and i + 1, with `lead` times the acceleration on top."""
    # Its derivative by tau is the term itself, `by_tau` times.
    if term.value == 0.0:
        return
    for r, p in ((i, 1.0), (AX, lead)):
        for c, q in ((i, tau), (AX, tau * lead)):
            model[r, c] += p * q * term.hxx
            model[r, c + 1] += p * q * term.hxy
            model[r + 1, c] += p * q * term.hxy
            model[r + 1, c + 1] += p * q * term.hyy
        for c, q in ((ONE, tau), (TAU, by_tau)):
            model[r, c] += p * q * term.gx
            model[c, r] += p * q * term.gx
            model[r + 1, c] += p * q * term.gy
            model[c, r + 1] += p * q * term.gy


@njit
def _times_step(
    model: np.ndarray, result: np.ndarray, rows: int, wx: float, wy: float, ax: float, ay: float, tau: float
) -> None:
    """Rows of a model after a step times the derivative of the step: of x, y, vx, vy by what they come from."""
    # w is the velocity at the end of the step: so much farther it leads if it takes longer.
    half = 0.5 * tau * tau
    for r in range(rows):
        x, y, vx, vy = model[r, 0], model[r, 1], model[r, 2], model[r, 3]
        result[r, 0], result[r, 1], result[r, 2], result[r, 3] = x, y, vx + tau * x, vy + tau * y
        result[r, TAU] = model[r, TAU] + wx * x + wy * y + ax * vx + ay * vy
        result[r, ONE], result[r, AX], result[r, AX + 1] = model[r, ONE], half * x + tau * vx, half * y + tau * vy


@njit
def _choose(model: np.ndarray, i: int, damping: float, most: float, gain: np.ndarray) -> None:
    """Writes the gain (7,) of the variable i that is best, and the model where it is taken."""
    # Where it would change by more than `most`, it changes by that, whatever comes before it.
    curvature, count = max(model[i, i], 0.0) + damping, max(i, AX)
    change = -model[i, ONE] / curvature
    for c in range(count):
        gain[c] = -model[i, c] / curvature if c != i and abs(change) <= most else 0.0
    gain[ONE] = min(max(change, -most), most)
    for r in range(count):
        for c in range(r, count):
            if r != i:
                model[r, c] += model[r, i] * gain[c]
                model[c, r] = model[r, c]
    model[i, :] = 0.0
    model[:, i] = 0.0


@njit
def _through_contact(problem: Problem, knots: Knots, k: int, phase: int, model: np.ndarray) -> None:
    """The model after the contact at knot k, which ends a phase, as one of the state before it."""
    grid, (x, y, _, _), (ax, ay) = problem.constants.grid, knots.states[k], knots.accelerations[k - 1]
    vx = knots.states[k - 1, 2] + knots.durations[phase] * ax
    vy = knots.states[k - 1, 3] + knots.durations[phase] * ay
    nx, ny = normal_at(problem.clearance, grid, x, y)
    xx, xy, yx, yy = rebound_slope(vx, vy, nx, ny, problem.constants.model.ring)
    for r in range(AX):
        p, q = model[r, 2], model[r, 3]
        model[r, 2], model[r, 3] = p * xx + q * yx, p * xy + q * yy
    for c in range(AX):
        p, q = model[2, c], model[3, c]
        model[2, c], model[3, c] = p * xx + q * yx, p * xy + q * yy
    place, hit = contact_terms(problem.constants, clearance_at(problem.clearance, grid, x, y), nx, ny, vx, vy)
    _add(model, place, X, 0.0, 1.0, 0.0)
    _add(model, hit, VX, 0.0, 1.0, 0.0)
