"""Initial plans of the refinement: the best coarse plans continued to the goal, and the rest of the plan in force."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.arrival import ON_THE_WAY, to_go
from collplan_core.time_to_goal_planner.coarse_search import SWITCH_STEPS, CoarsePlans
from collplan_core.time_to_goal_planner.control_interval import roll_interval
from collplan_core.time_to_goal_planner.dynamics import Motion, motion_at
from collplan_core.time_to_goal_planner.full_plan import FullPlan, clip, roll
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, INTERVAL_STEPS, Problem
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import path_direction

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
    motion = motion_at(clearance, constants.grid, x, y, vx, vy)
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
    bearing, max_speed = math.atan2(uy, ux), problem.constants.model.max_speed
    best, bx, by = np.inf, 0.0, 0.0
    for a in range(EXTENSION_TARGETS + 1):
        tx, ty = 0.0, 0.0
        if a < EXTENSION_TARGETS:
            angle = bearing + 2.0 * math.pi * a / EXTENSION_TARGETS
            tx, ty = max_speed * math.cos(angle), max_speed * math.sin(angle)
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
        ux, uy = clip(ux, uy, constants.model.max_speed)
        result[k, 0], result[k, 1] = ux, uy
        motion, _, arrival = roll_interval(clearance, source, constants, motion, ux, uy)
        if arrival != ON_THE_WAY:
            break
    return result
