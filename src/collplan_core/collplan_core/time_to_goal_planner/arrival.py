"""Arrival of a rollout at the goal: whether, since when, at what cost, and the time still needed otherwise."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import Grid, nearest_node
from collplan_core.time_to_goal_planner.dynamics import Motion
from collplan_core.time_to_goal_planner.model import GoalDisc, Problem, RobotModel
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import time_to_go

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
    goal, model = problem.constants.goal, problem.constants.model
    max_speed, max_acceleration = model.max_speed, model.wheels.max_acceleration
    passing = time_to_go(problem.paths, max_speed, max_acceleration, motion.x, motion.y, motion.vx, motion.vy)
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
def approach_speed(goal: GoalDisc, model: RobotModel, motion: Motion) -> float:
    """Speed to command on the way to the goal [m/s]: the top speed, or as much as still stops there."""
    if goal.rest_speed == math.inf:
        return model.max_speed
    left = math.hypot(motion.x - goal.x, motion.y - goal.y) - 0.5 * goal.tolerance
    return min(model.max_speed, math.sqrt(2.0 * APPROACH_SHARE * model.wheels.max_acceleration * max(left, 0.0)))


@njit
def least_time(length: np.ndarray, cells: Grid, goal: GoalDisc, max_speed: float, motion: Motion) -> float:
    """A time before which no rollout from here is at the goal, whatever its velocity [s]: full speed all the way.

    By the shortest path where that is known. Only a gap through which the disc fits by less than the width of a cell,
    which cells may leave out, can lead there sooner.

    Args:
        length: (mx, my) lengths of ShortestPaths [m], inf where there is none; cells: where its cells are.
    """
    x, y = motion.x, motion.y
    distance = math.sqrt((goal.x - x) * (goal.x - x) + (goal.y - y) * (goal.y - y)) - goal.tolerance
    i, j = nearest_node(cells, x, y)
    if 0 <= i < length.shape[0] and 0 <= j < length.shape[1]:
        along = length[i, j] - goal.longest_within - DETOUR * cells.spacing
        if distance < along < np.inf:
            distance = along
    return distance / max_speed


@njit
def end_cost(problem: Problem, motion: Motion) -> float:
    """Returns the cost [s] charged for the rest of the way, where a full plan ends before the goal."""
    return to_go(problem, motion) + UNREACHED_COST
