"""Coarse plans: one velocity for a while, then another, up to the horizon."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import ON_THE_WAY, arrival_share, graze_cost, is_there, to_go
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, Motion, contact_cost, step
from collplan_core.time_to_goal_planner.model import STEP, Constants, Problem
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import path_direction
from collplan_core.time_to_goal_planner.stopping import STOP_TEST_STEPS, stop_cost

SWITCH_STEPS = np.array([4, 10, 18, 28, 40])
"""Steps after which the first velocity is exchanged for the second."""


class CoarsePlans(NamedTuple):
    """Every pair of targets with every time of the switch.

    Attributes:
        targets: (25, 2) velocities [m/s].
        costs: (25, 5, 25) cost [s] by first target, switch and second target; inf where another one is the same.
        ends: (25, 5, 25, 4) x, y, vx, vy at the horizon or the goal.
    """

    targets: np.ndarray
    costs: np.ndarray
    ends: np.ndarray


class _Rollout(NamedTuple):
    """A rollout so far: what was charged [s], and how many steps it took."""

    motion: Motion
    cost: float
    steps: int


@njit
def targets(bearing: float, max_speed: float) -> np.ndarray:
    """(25, 2) velocities tried: 16 bearings at full speed, 8 at half, rest [m/s]."""
    result = np.zeros((25, 2))
    for n in range(16):
        result[n, 0] = max_speed * math.cos(bearing + n * math.pi / 8)
        result[n, 1] = max_speed * math.sin(bearing + n * math.pi / 8)
    for n in range(8):
        result[16 + n, 0] = 0.5 * max_speed * math.cos(bearing + n * math.pi / 4)
        result[16 + n, 1] = 0.5 * max_speed * math.sin(bearing + n * math.pi / 4)
    return result


@njit
def _roll_on(
    clearance: np.ndarray, source: np.ndarray, constants: Constants, rollout: _Rollout, ux: float, uy: float, last: int
) -> tuple[_Rollout, float]:
    """A rollout under command u until step `last` or the goal; time of arrival there [s] or ON_THE_WAY."""
    grid, goal, model, costs = constants
    motion, cost, first = rollout
    for k in range(first, last):
        before = motion
        motion, contact = step(clearance, source, grid, model, before, ux, uy)
        if contact.kind != NO_CONTACT:
            cost += contact_cost(costs, contact)
        if is_there(goal, motion):
            arrival = (k + arrival_share(goal, before, motion)) * STEP
            return _Rollout(motion, cost + graze_cost(goal, motion), k + 1), arrival
    return _Rollout(motion, cost, last), ON_THE_WAY


@njit
def coarse_plans(problem: Problem, initial: Motion, n_steps: int) -> CoarsePlans:
    """Rolls all coarse plans up to the horizon of n_steps; those with an equal beginning share its rollout."""
    clearance, source, constants = problem.clearance, problem.source, problem.constants
    ux, uy, _ = path_direction(problem.paths, initial.x, initial.y)
    velocities = targets(math.atan2(uy, ux), constants.model.max_speed)
    n, m = len(velocities), len(SWITCH_STEPS)
    costs, ends = np.full((n, m, n), np.inf), np.zeros((n, m, n, 4))
    for a in range(n):
        trunk, unstoppable = _Rollout(initial, 0.0, 0), 0.0
        for b in range(m):
            begun, switch = trunk.steps, min(SWITCH_STEPS[b], n_steps)
            trunk, arrival = _roll_on(clearance, source, constants, trunk, velocities[a, 0], velocities[a, 1], switch)
            if arrival != ON_THE_WAY:
                costs[a, b, a] = arrival + trunk.cost + unstoppable
                end = trunk.motion
                ends[a, b, a, 0], ends[a, b, a, 1], ends[a, b, a, 2], ends[a, b, a, 3] = end.x, end.y, end.vx, end.vy
                break
            if problem.stop_test and begun < STOP_TEST_STEPS <= switch:
                unstoppable = stop_cost(problem, trunk.motion)
            for c in range(n):
                if c == a and b < m - 1:  # the same rollout comes with the last switch
                    continue
                branch, arrival = _roll_on(
                    clearance, source, constants, trunk, velocities[c, 0], velocities[c, 1], n_steps
                )
                if arrival == ON_THE_WAY:
                    arrival = n_steps * STEP + to_go(problem, branch.motion)
                costs[a, b, c] = arrival + branch.cost + unstoppable
                end = branch.motion
                ends[a, b, c, 0], ends[a, b, c, 1], ends[a, b, c, 2], ends[a, b, c, 3] = end.x, end.y, end.vx, end.vy
    return CoarsePlans(velocities, costs, ends)
