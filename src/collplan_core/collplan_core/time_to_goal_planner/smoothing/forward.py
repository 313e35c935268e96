"""Forward pass: the trajectory that changed accelerations and durations lead to, and what it costs."""

import numpy as np

from collplan_core.jit import njit
from collplan_core.reflection import reflect
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at, normal_at
from collplan_core.time_to_goal_planner.model import Problem
from collplan_core.time_to_goal_planner.smoothing.cost import OFF_GOAL, OFF_SPEED, SLOWER, beyond, contact_terms, stage
from collplan_core.time_to_goal_planner.smoothing.knots import AX, ONE, TAU, Gains, Knots

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
