"""Initial plans of the refinement: the best coarse plans continued to the goal, and the rest of the plan in force.

A coarse plan is one velocity for a while, then another, up to the horizon.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import (
    ON_THE_WAY,
    STOP_TEST_STEPS,
    arrival_share,
    graze_cost,
    is_there,
    least_time,
    roll_interval,
    stop_cost,
    to_go,
)
from collplan_core.time_to_goal_planner.boundary_memory.clearance import Grid
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, Motion, contact_cost, course_of, motion_at, step
from collplan_core.time_to_goal_planner.full_plan import FullPlan, roll
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, INTERVAL_STEPS, STEP, Constants, Problem
from collplan_core.time_to_goal_planner.mover_cost import mover_cost
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import path_direction
from collplan_core.velocity_bounds import fastest_along, within

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
    """Every pair of targets with every time of the switch."""

    targets: np.ndarray  # (n, 2) velocities [m/s]
    costs: np.ndarray
    """(n, 5, n) cost [s] by first target, switch and second target; inf where another is the same or it is given up."""
    ends: np.ndarray  # (n, 5, n, 4) x, y, vx, vy at the horizon or the goal


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
    movers: np.ndarray
    trails: np.ndarray


@njit
def targets(problem: Problem, initial: Motion) -> np.ndarray:
    """(25, 2) velocities to try: 16 bearings at full speed from that of the path on, 8 at half, rest [m/s]."""
    ux, uy, _ = path_direction(problem.paths, initial.x, initial.y)
    bearing, bounds = math.atan2(uy, ux), problem.constants.bounds
    result = np.zeros((25, 2))
    for n in range(24):
        share, angle = (1.0, bearing + n * math.pi / 8) if n < 16 else (0.5, bearing + (n - 16) * math.pi / 4)
        x, y = math.cos(angle), math.sin(angle)
        speed = share * fastest_along(bounds, x, y)
        result[n, 0], result[n, 1] = speed * x, speed * y
    return result


@njit
def _roll_on(
    field: _Field, constants: Constants, rollout: _Rollout, ux: float, uy: float, last: int, limit: float
) -> tuple[_Rollout, float]:
    """A rollout under u until step `last` or the goal; time of arrival [s], ON_THE_WAY, or TOO_LATE for `limit` [s]."""
    clearance, source, length, cells, movers, trails = field
    grid, goal, model, costs, bounds = constants
    motion, cost, first = rollout
    course = course_of(motion, ux, uy)
    for k in range(first, last):
        before = motion
        motion, course, contact = step(clearance, source, grid, model, before, course)
        if contact.kind != NO_CONTACT:
            cost += contact_cost(costs, contact)
        if len(movers) + len(trails) > 0:
            cost += mover_cost(movers, trails, (k + 1) * STEP, STEP, motion)
        if is_there(goal, motion):
            arrival = (k + arrival_share(goal, before, motion)) * STEP
            return _Rollout(motion, cost + graze_cost(goal, motion), k + 1), arrival
        if (k + 1) % LOOK_STEPS == 0:
            left = least_time(length, cells, goal, bounds, motion)
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
    field = _Field(
        problem.clearance, problem.source, problem.paths.length, problem.paths.cells, problem.movers, problem.trails
    )
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


TRACKING_GAIN = 2.5
"""Gain with which the plan in force is tracked, where its own commands led beside it [1/s]."""
EXTENSION_TARGETS = 12
"""Bearings tried at each step of an extension to the goal, and rest."""
EXTENSION_INTERVALS, EXTENSION_TRIED = 2, 4
"""Control intervals taken with the best of them, and intervals tried."""


def best_coarse(costs: np.ndarray, count: int) -> list[tuple[int, int, int]]:
    """Places (first target, switch, second target) of the cheapest coarse plans with different first targets.

    As many as are finite, and `count` at most.
    """
    n = len(costs)
    flat = costs.reshape(n, -1)
    within = flat.argmin(axis=1)
    cheapest = flat[np.arange(n), within]
    order = [a for a in np.argsort(cheapest, kind="stable")[:count] if cheapest[a] < np.inf]
    places = [np.unravel_index(int(within[a]), costs.shape[1:]) for a in order]
    return [(int(a), int(b), int(c)) for a, (b, c) in zip(order, places, strict=True)]


def coarse_commands(
    coarse: CoarsePlans,
    place: tuple[int, int, int],
    n_steps: int,
    size: int,
) -> tuple[np.ndarray, int]:
    """Commands (size, 2) of the coarse plan at a place (first target, switch, second target); intervals in use."""
    a, b, c = place
    commands, switch = np.zeros((size, 2)), SWITCH_STEPS[b] // INTERVAL_STEPS
    n = min(n_steps // INTERVAL_STEPS, size)
    commands[: min(switch, n)] = coarse.targets[a]
    commands[switch:n] = coarse.targets[c]
    return commands, n


def extended(problem: Problem, initial: Motion, commands: np.ndarray, n: int) -> FullPlan:
    """The plan of commands (m, 2) up to number n, carried on to the goal if they do not lead there."""
    plan = roll(problem, initial, commands, n)
    return roll(problem, initial, plan.commands, extend_to_goal(problem, plan)) if plan.n == n else plan


@njit
def extend_to_goal(problem: Problem, plan: FullPlan) -> int:
    """Adds commands to a plan greedily by the time to go, in place; number of its commands then."""
    clearance, source, constants = problem.clearance, problem.source, problem.constants
    x, y, vx, vy = plan.states[plan.n]
    motion = motion_at(clearance, constants.grid, x, y, vx, vy, plan.n * INTERVAL_STEPS)
    n, most = plan.n, len(plan.commands)
    while n < most:
        ux, uy = _best_target(problem, motion)
        for _ in range(EXTENSION_INTERVALS):
            if n == most:
                return n
            plan.commands[n, 0], plan.commands[n, 1] = ux, uy
            n += 1
            motion, _, arrival = roll_interval(clearance, source, constants, motion, ux, uy)
            if arrival != ON_THE_WAY:
                return n
    return n


@njit
def _best_target(problem: Problem, motion: Motion) -> tuple[float, float]:
    """The velocity that is best to command for a while: one of some bearings at full speed, or rest."""
    ux, uy, _ = path_direction(problem.paths, motion.x, motion.y)
    bearing, bounds = math.atan2(uy, ux), problem.constants.bounds
    best, bx, by = np.inf, 0.0, 0.0
    for a in range(EXTENSION_TARGETS + 1):
        tx, ty = 0.0, 0.0
        if a < EXTENSION_TARGETS:
            angle = bearing + 2.0 * math.pi * a / EXTENSION_TARGETS
            x, y = math.cos(angle), math.sin(angle)
            speed = fastest_along(bounds, x, y)
            tx, ty = speed * x, speed * y
        cost = _cost_if_held(problem, motion, tx, ty)
        if cost < best:
            best, bx, by = cost, tx, ty
    return bx, by


@njit
def _cost_if_held(problem: Problem, motion: Motion, ux: float, uy: float) -> float:
    """Cost up to the goal of command u for EXTENSION_TRIED intervals and the time to go from there [s]."""
    total = 0.0
    for k in range(EXTENSION_TRIED):
        motion, cost, arrival = roll_interval(problem.clearance, problem.source, problem.constants, motion, ux, uy)
        total += cost
        if arrival != ON_THE_WAY:
            return total + (k * CONTROL_INTERVAL + arrival)
    return total + (EXTENSION_TRIED * CONTROL_INTERVAL + to_go(problem, motion))


def shifted(commands: np.ndarray, passed: float) -> np.ndarray:
    """The rest of commands (n, 2), one a control interval, once `passed` [s] have gone by.

    By the command in force in the middle of each interval.
    """
    middles = passed + CONTROL_INTERVAL * (np.arange(len(commands)) + 0.5)
    at = np.floor(middles / CONTROL_INTERVAL).astype(int)
    return commands[at[(at >= 0) & (at < len(commands))]]


def padded(commands: np.ndarray, size: int) -> np.ndarray:
    """Commands (n, 2) in an array (size, 2)."""
    result = np.zeros((size, 2))
    result[: len(commands)] = commands[:size]
    return result


@njit
def tracked(problem: Problem, initial: Motion, commands: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Commands (n, 2) that lead back to the positions (n, 2) where the given ones should have led [m/s]."""
    clearance, source, constants = problem.clearance, problem.source, problem.constants
    result, motion = commands.copy(), initial
    for k in range(len(commands)):
        ux = commands[k, 0] + TRACKING_GAIN * (positions[k, 0] - motion.x)
        uy = commands[k, 1] + TRACKING_GAIN * (positions[k, 1] - motion.y)
        ux, uy = within(constants.bounds, ux, uy)
        result[k, 0], result[k, 1] = ux, uy
        motion, _, arrival = roll_interval(clearance, source, constants, motion, ux, uy)
        if arrival != ON_THE_WAY:
            break
    return result
