"""Cost of a rollout: of each control interval, and of its arrival at the goal; whether the robot could still brake."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import Grid, clearance_at, nearest_node
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, Motion, contact_cost, course_of, margin_cost, step
from collplan_core.time_to_goal_planner.model import INTERVAL_STEPS, STEP, Constants, GoalDisc, Problem
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import time_to_go
from collplan_core.velocity_bounds import VelocityBounds, share_along

STOP_TEST_STEPS = 4
"""Steps after which the robot must be able to brake within what was seen, where the strategy demands it."""
UNSTOPPABLE = 100.0
"""Cost of failing the stop test, added to that of a plan [s]."""
BRAKING_SHARE = 0.9
"""Share of the largest acceleration that braking counts on."""
SWERVES = (0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2)
"""Bearings off straight back in which the first half of the braking pushes [rad]."""


@njit
def _is_free(problem: Problem, x: float, y: float) -> bool:
    """Returns whether the disc was seen to be free at the node nearest to (x, y) [m]."""
    nx, ny = problem.free.shape
    grid = problem.constants.grid
    i, j = nearest_node(grid, x, y)
    return 0 <= i < nx and 0 <= j < ny and problem.free[i, j]


@njit
def _stops(problem: Problem, motion: Motion, swerve: float) -> bool:
    """Returns whether braking that first pushes `swerve` [rad] off straight back touches nothing and ends free."""
    grid, brake = problem.constants.grid, BRAKING_SHARE * problem.constants.model.wheels.max_acceleration
    x, y, vx, vy, _, _ = motion
    speed = math.hypot(vx, vy)
    if speed > 1e-9:
        c, s = -math.cos(swerve) / speed, -math.sin(swerve) / speed
        ax, ay = brake * (c * vx - s * vy), brake * (s * vx + c * vy)
        first = max(int(0.5 * speed / brake / STEP), 1)
        for k in range(400):
            if k >= first:
                speed = math.hypot(vx, vy)
                if speed <= brake * STEP:
                    break
                ax, ay = -brake * vx / speed, -brake * vy / speed
            x, y = x + vx * STEP + 0.5 * ax * STEP * STEP, y + vy * STEP + 0.5 * ay * STEP * STEP
            vx, vy = vx + ax * STEP, vy + ay * STEP
            if clearance_at(problem.clearance, grid, x, y) < 0.0:
                return False
    return _is_free(problem, x, y)


@njit
def admits_stop(problem: Problem, motion: Motion) -> bool:
    """Returns whether some two-phase braking from a motion touches nothing and ends where the disc was seen free."""
    for swerve in SWERVES:  # noqa: SIM110 (numba has no generators)
        if _stops(problem, motion, swerve):
            return True
    return False


@njit
def stop_cost(problem: Problem, motion: Motion) -> float:
    """Cost of a motion from which the robot cannot brake within what it has seen [s]."""
    return 0.0 if admits_stop(problem, motion) else UNSTOPPABLE


ON_THE_WAY = -1.0
"""Stands for the time of an arrival where there is none yet."""
UNREACHED_COST = 0.3
"""Cost, beyond the time to go, of a full plan that does not reach the goal [s]."""
DETOUR = 2.0
"""So much longer than need be may a shortest path over cells be; what it is beyond that, a rollout loses at its turns
[cells]."""

APPROACH_SHARE = 0.6
"""Share of the largest acceleration with which a simple way to a goal brakes before it."""


@njit
def is_there(goal: GoalDisc, motion: Motion) -> bool:
    """Returns whether a motion is within the goal's tolerance, and as slow as it must be there."""
    x, y = motion.x, motion.y
    if motion.vx * motion.vx + motion.vy * motion.vy > goal.rest_speed * goal.rest_speed:
        return False
    return (x - goal.x) * (x - goal.x) + (y - goal.y) * (y - goal.y) <= goal.tolerance * goal.tolerance


@njit
def arrival_share(goal: GoalDisc, begin: Motion, end: Motion) -> float:
    """Share of a step, which ends at the goal, after which it comes there."""
    x, y, px, py = begin.x, begin.y, end.x, end.y
    before = math.sqrt((x - goal.x) * (x - goal.x) + (y - goal.y) * (y - goal.y))
    after = math.sqrt((px - goal.x) * (px - goal.x) + (py - goal.y) * (py - goal.y))
    share = (before - goal.tolerance) / (before - after) if before > goal.tolerance else 0.0
    fast = math.hypot(begin.vx, begin.vy)
    if fast > goal.rest_speed:
        share = max(share, (fast - goal.rest_speed) / (fast - math.hypot(end.vx, end.vy)))
    return share


@njit
def graze_cost(goal: GoalDisc, motion: Motion) -> float:
    """Cost of an arrival by the distance at which its line passes the goal's centre [s]."""
    vx, vy = motion.vx, motion.vy
    speed2 = vx * vx + vy * vy
    if speed2 < 1e-12:
        return 0.0
    offset = vx * (goal.y - motion.y) - vy * (goal.x - motion.x)
    return goal.graze_cost * offset * offset / speed2


@njit
def to_go(problem: Problem, motion: Motion) -> float:
    """Time to go from a motion over what is known, and to come to rest where the goal asks for it [s]."""
    goal, bounds = problem.constants.goal, problem.constants.bounds
    max_acceleration = problem.constants.model.wheels.max_acceleration
    passing = time_to_go(problem.paths, bounds, max_acceleration, motion.x, motion.y, motion.vx, motion.vy)
    return passing + _stopping_time(goal, max_acceleration, motion)


@njit
def _stopping_time(goal: GoalDisc, max_acceleration: float, motion: Motion) -> float:
    """About how much longer it takes to rest at the goal than to pass it: by braking, and by coming back [s]."""
    speed = math.hypot(motion.vx, motion.vy)
    if speed <= goal.rest_speed:
        return 0.0
    braking, left = 0.5 * speed * speed / max_acceleration, math.hypot(motion.x - goal.x, motion.y - goal.y)
    too_far = max(braking - left - goal.tolerance, 0.0)
    share = min(braking / max(left, goal.tolerance), 1.0)
    return 0.5 * share * speed / max_acceleration + 2.0 * math.sqrt(too_far / max_acceleration)


@njit
def approach_speed(constants: Constants, motion: Motion) -> float:
    """Speed to command on the way to the goal [m/s]: the largest of any direction, or as much as still stops there."""
    goal, fastest = constants.goal, constants.bounds.fastest
    if goal.rest_speed == math.inf:
        return fastest
    left = math.hypot(motion.x - goal.x, motion.y - goal.y) - 0.5 * goal.tolerance
    acceleration = constants.model.wheels.max_acceleration
    return min(fastest, math.sqrt(2.0 * APPROACH_SHARE * acceleration * max(left, 0.0)))


@njit
def straight_time(goal: GoalDisc, bounds: VelocityBounds, motion: Motion) -> float:
    """A time before which nothing is at the goal's disc, whatever is in between [s]."""
    dx, dy = goal.x - motion.x, goal.y - motion.y
    return (math.sqrt(dx * dx + dy * dy) * share_along(bounds, dx, dy) - goal.tolerance) / bounds.max_speed


@njit
def least_time(length: np.ndarray, cells: Grid, goal: GoalDisc, bounds: VelocityBounds, motion: Motion) -> float:
    """A time before which no rollout from here is at the goal, whatever its velocity [s]: full speed all the way.

    By the shortest path where `length` (mx, my) [m], on the cells, knows it. Only a gap through which the disc fits by
    less than the width of a cell, which cells may leave out, can lead there sooner.
    """
    time = straight_time(goal, bounds, motion)
    i, j = nearest_node(cells, motion.x, motion.y)
    if 0 <= i < length.shape[0] and 0 <= j < length.shape[1]:
        along = (length[i, j] - goal.longest_within - DETOUR * cells.spacing) / bounds.fastest
        if time < along < np.inf:
            time = along
    return time


@njit
def end_cost(problem: Problem, motion: Motion) -> float:
    """Returns the cost [s] charged for the rest of the way, where a full plan ends before the goal."""
    return to_go(problem, motion) + UNREACHED_COST


@njit
def roll_interval(
    clearance: np.ndarray, source: np.ndarray, constants: Constants, begin: Motion, ux: float, uy: float
) -> tuple[Motion, float, float]:
    """A control interval under command u: motion after it, cost [s], time of arrival in it [s], or ON_THE_WAY."""
    grid, goal, model, costs, _ = constants
    motion, course, cost, touched = begin, course_of(begin, ux, uy), 0.0, False
    for k in range(INTERVAL_STEPS):
        before = motion
        motion, course, contact = step(clearance, source, grid, model, before, course)
        if contact.kind != NO_CONTACT:
            touched = True
            cost += contact_cost(costs, contact)
        if is_there(goal, motion):
            cost += graze_cost(goal, motion)
            return motion, cost, (k + arrival_share(goal, before, motion)) * STEP
    if not touched and motion.clearance_bound < costs.margin:
        cost += margin_cost(clearance, grid, costs, motion)
    return motion, cost, ON_THE_WAY
