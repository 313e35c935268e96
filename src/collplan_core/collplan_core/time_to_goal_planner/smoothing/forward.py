"""Forward pass: the trajectory that changed accelerations and durations lead to, and what it costs."""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.reflection import reflect
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at, normal_at
from collplan_core.time_to_goal_planner.model import Constants
from collplan_core.time_to_goal_planner.smoothing.cost import OFF_GOAL, Limits, beyond, contact_terms, rate, stage
from collplan_core.time_to_goal_planner.smoothing.knots import Gains, Knots

MOST_CHANGE = 0.3
"""Largest change of a duration in one pass, as a share of it."""
TAU, ONE = 4, 5
"""Columns of gains beside those of the state: of the change of duration, and of what the model asks for."""


class Course(NamedTuple):
    """What passes go over.

    Attributes:
        clearance: (nx, ny) as in ClearanceField; constants: of the problem.
        limits: what a smooth plan keeps to; margins: (n,) clearance kept at each knot [m].
    """

    clearance: np.ndarray
    constants: Constants
    limits: Limits
    margins: np.ndarray


@njit
def forward(course: Course, old: Knots, gains: Gains, share: float, new: Knots) -> float:
    """Writes the trajectory that `share` of what the gains ask for leads to into `new`; its cost [s]."""
    clearance, grid, limits = course.clearance, course.constants.grid, course.limits
    ring, goal, n = course.constants.model.ring, course.constants.goal, old.ends[-1]
    new.states[0] = old.states[0]
    cost, phase, first, tau, change = 0.0, 0, 0, 0.0, 0.0
    for k in range(n):
        state, off = new.states[k], old.states[k]
        if k == first:
            change = share * gains.durations[phase, ONE]
            for c in range(4):
                change += gains.durations[phase, c] * (state[c] - off[c])
            most = MOST_CHANGE * old.durations[phase]
            change = min(max(change, -most), most)
            tau = old.durations[phase] + change
            new.durations[phase] = tau
        for r in range(2):
            gain = gains.accelerations[k, r]
            new.accelerations[k, r] = old.accelerations[k, r] + share * gain[ONE] + gain[TAU] * change
            for c in range(4):
                new.accelerations[k, r] += gain[c] * (state[c] - off[c])
        ax, ay = new.accelerations[k]
        cost += tau * rate(stage(clearance, grid, limits, course.margins[k], state, ax, ay))
        x, y = state[0] + tau * (state[2] + 0.5 * tau * ax), state[1] + tau * (state[3] + 0.5 * tau * ay)
        vx, vy = state[2] + tau * ax, state[3] + tau * ay
        if k + 1 == old.ends[phase] < n:
            nx, ny = normal_at(clearance, grid, x, y)
            place, hit = contact_terms(limits, clearance_at(clearance, grid, x, y), nx, ny, vx, vy)
            cost += place.value + hit.value
            vx, vy, _ = reflect(vx, vy, 0.0, nx, ny, ring)
            phase, first = phase + 1, k + 1
        after = new.states[k + 1]
        after[0], after[1], after[2], after[3] = x, y, vx, vy
    x, y, _, _ = new.states[n]
    return cost + beyond(OFF_GOAL, x - goal.x, y - goal.y, goal.tolerance).value
