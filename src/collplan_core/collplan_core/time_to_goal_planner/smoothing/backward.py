"""Backward pass: from the quadratic model of the cost to go at each knot to what changes of the trajectory lower it.

A model is a symmetric matrix over changes of x, y, vx, vy, the duration tau and 1: its last column is the gradient.
"""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.reflection import reflection_slope
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at, normal_at
from collplan_core.time_to_goal_planner.smoothing.cost import OFF_GOAL, Term, beyond, contact_terms, rate, stage
from collplan_core.time_to_goal_planner.smoothing.forward import MOST_CHANGE, ONE, TAU, Course
from collplan_core.time_to_goal_planner.smoothing.knots import Gains, Knots

PLACE, SPEED, ACCELERATION = 0, 2, 6
"""First of the two variables of each in a model; acceleration is in that of a step alone."""
LEAST_CURVATURE = 1e-3
"""Least second derivative by a duration that is divided by [1/s]."""


class Models(NamedTuple):
    """Room for models: (6, 6) at a knot, (6, 8) half way through a step, (8, 8) of a step with its acceleration."""

    to_go: np.ndarray
    half: np.ndarray
    step: np.ndarray


@njit
def empty_models() -> Models:
    """Room for models."""
    return Models(np.zeros((6, 6)), np.zeros((6, 8)), np.zeros((8, 8)))


@njit
def backward(course: Course, knots: Knots, damping: float, models: Models, gains: Gains) -> bool:
    """Writes the gains that lower the cost of a trajectory; False where its model has no minimum.

    Args:
        damping: added to the second derivative by accelerations [s^5/m^2].
    """
    clearance, grid, limits = course.clearance, course.constants.grid, course.limits
    states, ends, goal, n = knots.states, knots.ends, course.constants.goal, knots.ends[-1]
    models.to_go[:] = 0.0
    x, y, _, _ = states[n]
    _add(models.to_go, beyond(OFF_GOAL, x - goal.x, y - goal.y, goal.tolerance), PLACE)
    phase = len(ends) - 1
    for k in range(n - 1, -1, -1):
        tau = knots.durations[phase]
        ax, ay = knots.accelerations[k]
        terms = stage(clearance, grid, limits, course.margins[k], states[k], ax, ay)
        _through_step(models, states[k, 2] + tau * ax, states[k, 3] + tau * ay, ax, ay, tau)
        step = models.step
        _add_held(step, terms.place, PLACE, PLACE, 0.0, tau)
        _add_held(step, terms.speed, SPEED, ACCELERATION, limits.lag, tau)
        _add_held(step, terms.acceleration, ACCELERATION, ACCELERATION, 0.0, tau)
        step[TAU, ONE] += rate(terms)
        step[ONE, TAU] += rate(terms)
        if not _choose_acceleration(models, damping, gains.accelerations[k]):
            return False
        if k == (ends[phase - 1] if phase > 0 else 0):
            _choose_duration(models.to_go, MOST_CHANGE * tau, gains.durations[phase])
            phase -= 1
            if phase >= 0:
                _through_contact(course, knots, k, phase, models.to_go)
    return True


@njit
def _add(model: np.ndarray, term: Term, i: int) -> None:
    """Adds a term of the variables i and i + 1."""
    model[i, i] += term.hxx
    model[i, i + 1] += term.hxy
    model[i + 1, i] += term.hxy
    model[i + 1, i + 1] += term.hyy
    model[i, ONE] += term.gx
    model[ONE, i] += term.gx
    model[i + 1, ONE] += term.gy
    model[ONE, i + 1] += term.gy


@njit
def _add_held(model: np.ndarray, term: Term, i: int, j: int, lead: float, tau: float) -> None:
    """Adds tau times a term of the variables i and i + 1 with `lead` times j and j + 1 on top."""
    if term.value == 0.0:
        return
    for r, p in ((i, 1.0), (j, lead)):
        for c, q in ((i, 1.0), (j, lead)):
            weight = tau * p * q
            model[r, c] += weight * term.hxx
            model[r, c + 1] += weight * term.hxy
            model[r + 1, c] += weight * term.hxy
            model[r + 1, c + 1] += weight * term.hyy
        for c, q in ((ONE, tau), (TAU, 1.0)):
            model[r, c] += p * q * term.gx
            model[c, r] += p * q * term.gx
            model[r + 1, c] += p * q * term.gy
            model[c, r + 1] += p * q * term.gy


@njit
def _through_step(models: Models, wx: float, wy: float, ax: float, ay: float, tau: float) -> None:
    """The model after a step as one of what leads there: F' V F, F the derivative of the step.

    w is the velocity at its end: as much farther on it would lead if it took longer.
    """
    _times_step(models.to_go, models.half, wx, wy, ax, ay, tau)
    _times_step(models.half.T, models.step, wx, wy, ax, ay, tau)


@njit
def _times_step(model: np.ndarray, result: np.ndarray, wx: float, wy: float, ax: float, ay: float, tau: float) -> None:
    """Each row of a model (n, 6) times the derivative of the step, as a row of `result` (n, 8)."""
    half = 0.5 * tau * tau
    for r in range(len(model)):
        x, y, vx, vy = model[r, 0], model[r, 1], model[r, 2], model[r, 3]
        result[r, 0], result[r, 1] = x, y
        result[r, 2], result[r, 3] = vx + tau * x, vy + tau * y
        result[r, TAU] = model[r, TAU] + wx * x + wy * y + ax * vx + ay * vy
        result[r, ONE] = model[r, ONE]
        result[r, 6], result[r, 7] = half * x + tau * vx, half * y + tau * vy


@njit
def _choose_acceleration(models: Models, damping: float, gain: np.ndarray) -> bool:
    """Writes the gains (2, 6) of the acceleration that is best, and the model where it is taken; False without one."""
    step, to_go, a = models.step, models.to_go, ACCELERATION
    xx, xy, yy = step[a, a] + damping, step[a, a + 1], step[a + 1, a + 1] + damping
    determinant = xx * yy - xy * xy
    if not (xx > 0.0 and determinant > 1e-14):
        return False
    for c in range(6):
        gain[0, c] = -(yy * step[a, c] - xy * step[a + 1, c]) / determinant
        gain[1, c] = -(xx * step[a + 1, c] - xy * step[a, c]) / determinant
    for r in range(6):
        for c in range(6):
            to_go[r, c] = step[r, c] + step[r, a] * gain[0, c] + step[r, a + 1] * gain[1, c]
    return True


@njit
def _choose_duration(to_go: np.ndarray, most: float, gain: np.ndarray) -> None:
    """Writes the gains (6,) of the duration that is best, and the model where it is taken.

    Where it would change by more than `most` [s], it changes by that, whatever comes before it.
    """
    curvature = max(to_go[TAU, TAU], LEAST_CURVATURE)
    change = -to_go[TAU, ONE] / curvature
    for c in range(6):
        gain[c] = -to_go[TAU, c] / curvature if abs(change) <= most else 0.0
    gain[TAU], gain[ONE] = 0.0, min(max(change, -most), most)
    for r in range(6):
        for c in range(6):
            if r != TAU and c != TAU:
                to_go[r, c] += to_go[r, TAU] * gain[c] + gain[r] * (to_go[TAU, c] + curvature * gain[c])
    to_go[TAU, :] = 0.0
    to_go[:, TAU] = 0.0


@njit
def _through_contact(course: Course, knots: Knots, k: int, phase: int, to_go: np.ndarray) -> None:
    """The model after the contact at knot k, which ends a phase, as one of the state before it."""
    x, y, _, _ = knots.states[k]
    tau, (ax, ay) = knots.durations[phase], knots.accelerations[k - 1]
    vx, vy = knots.states[k - 1, 2] + tau * ax, knots.states[k - 1, 3] + tau * ay
    grid = course.constants.grid
    nx, ny = normal_at(course.clearance, grid, x, y)
    xx, xy, yx, yy = reflection_slope(vx, vy, nx, ny, course.constants.model.ring)
    for r in range(6):
        before, across = to_go[r, 2], to_go[r, 3]
        to_go[r, 2], to_go[r, 3] = before * xx + across * yx, before * xy + across * yy
    for c in range(6):
        before, across = to_go[2, c], to_go[3, c]
        to_go[2, c], to_go[3, c] = before * xx + across * yx, before * xy + across * yy
    place, hit = contact_terms(course.limits, clearance_at(course.clearance, grid, x, y), nx, ny, vx, vy)
    _add(to_go, place, PLACE)
    _add(to_go, hit, SPEED)
