"""Coarse plans: one velocity for a while, then another, up to the horizon."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import (
    ON_THE_WAY,
    arrival_share,
    graze_cost,
    is_there,
    least_time,
    to_go,
)
from collplan_core.time_to_goal_planner.boundary_memory.clearance import Grid
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, Motion, contact_cost, course_of, step
from collplan_core.time_to_goal_planner.model import STEP, Constants, Problem
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import path_direction
from collplan_core.time_to_goal_planner.stopping import STOP_TEST_STEPS, stop_cost

SWITCH_STEPS = np.array([4, 10, 18, 28, 40])
"""Steps after which the first velocity is exchanged for the second."""
TOO_LATE = -2.0
"""Stands for the time of an arrival that cannot be early enough."""
MARGIN = 0.4
"""A coarse plan that can only be this much worse than the best plan is given up: refinement seldom makes up for so
much [s]."""
LOOK_STEPS = 4
"""Steps between two looks at whether a rollout can still be early enough."""


class CoarsePlans(NamedTuple):
    """Every pair of targets with every time of the switch.

    Attributes:
        targets: (n, 2) velocities [m/s].
        costs: (n, 5, n) cost [s] by first target, switch and second target; inf where another one is the same, and
            where it was given up.
        ends: (n, 5, n, 4) x, y, vx, vy at the horizon or the goal.
    """

    targets: np.ndarray
    costs: np.ndarray
    ends: np.ndarray


class _Rollout(NamedTuple):
    """A rollout so far: its cost [s] and number of steps."""

    motion: Motion
    cost: float
    steps: int


class _Field(NamedTuple):
    """Arrays that rollouts look up: of a Problem, and length and cells of its shortest paths."""

    clearance: np.ndarray
    source: np.ndarray
    length: np.ndarray
    cells: Grid


@njit
def targets(problem: Problem, initial: Motion) -> np.ndarray:
    """(25, 2) velocities to try: 16 bearings at full speed from that of the path on, 8 at half, rest [m/s]."""
    ux, uy, _ = path_direction(problem.paths, initial.x, initial.y)
    bearing, max_speed = math.atan2(uy, ux), problem.constants.model.max_speed
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
    field: _Field, constants: Constants, rollout: _Rollout, ux: float, uy: float, last: int, limit: float
) -> tuple[_Rollout, float]:
    """A rollout under command u until step `last` or the goal.

    Returns:
        where it is then; time of arrival at the goal [s], ON_THE_WAY, or TOO_LATE once it will cost over `limit` [s].
    """
    clearance, source, length, cells = field
    grid, goal, model, costs = constants
    motion, cost, first = rollout
    course = course_of(motion, ux, uy)
    for k in range(first, last):
        before = motion
        motion, course, contact = step(clearance, source, grid, model, before, course)
        if contact.kind != NO_CONTACT:
            cost += contact_cost(costs, contact)
        if is_there(goal, motion):
            arrival = (k + arrival_share(goal, before, motion)) * STEP
            return _Rollout(motion, cost + graze_cost(goal, motion), k + 1), arrival
        if (k + 1) % LOOK_STEPS == 0:
            left = least_time(length, cells, goal, model.max_speed, motion)
            if (k + 1) * STEP + cost + left > limit:
                return _Rollout(motion, cost, k + 1), TOO_LATE
    return _Rollout(motion, cost, last), ON_THE_WAY


@njit
def coarse_plans(
    problem: Problem, initial: Motion, velocities: np.ndarray, n_steps: int, best: float, margin: float
) -> CoarsePlans:
    """Rolls coarse plans of velocities (n, 2) [m/s] to the horizon of n_steps; equal beginnings share their rollout.

    One that will cost over `margin` more than the best of them, or than `best` [s], is given up.
    """
    constants, limit = problem.constants, best + margin
    field = _Field(problem.clearance, problem.source, problem.paths.length, problem.paths.cells)
    n, m = len(velocities), len(SWITCH_STEPS)
    costs, ends = np.full((n, m, n), np.inf), np.zeros((n, m, n, 4))
    for a in range(n):
        trunk, unstoppable = _Rollout(initial, 0.0, 0), 0.0
        for b in range(m):
            begun, switch = trunk.steps, min(SWITCH_STEPS[b], n_steps)
            ux, uy = velocities[a]
            trunk, arrival = _roll_on(field, constants, trunk, ux, uy, switch, limit - unstoppable)
            if arrival == TOO_LATE:
                break
            if arrival != ON_THE_WAY:
                costs[a, b, a] = arrival + trunk.cost + unstoppable
                limit = min(limit, costs[a, b, a] + margin)
                _put(ends[a, b, a], trunk.motion)
                break
            if problem.stop_test and begun < STOP_TEST_STEPS <= switch:
                unstoppable = stop_cost(problem, trunk.motion)
            for c in range(n):
                if c == a and b < m - 1:  # the same rollout comes with the last switch
                    continue
                ux, uy = velocities[c]
                branch, arrival = _roll_on(field, constants, trunk, ux, uy, n_steps, limit - unstoppable)
                if arrival == TOO_LATE:
                    continue
                if arrival == ON_THE_WAY:
                    arrival = n_steps * STEP + to_go(problem, branch.motion)
                costs[a, b, c] = arrival + branch.cost + unstoppable
                limit = min(limit, costs[a, b, c] + margin)
                _put(ends[a, b, c], branch.motion)
    return CoarsePlans(velocities, costs, ends)


@njit
def _put(row: np.ndarray, motion: Motion) -> None:
    row[0], row[1], row[2], row[3] = motion.x, motion.y, motion.vx, motion.vy
