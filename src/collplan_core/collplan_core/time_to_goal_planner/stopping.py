"""Stopping test: whether the robot could still brake within what it has seen."""

import math

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at, nearest_node
from collplan_core.time_to_goal_planner.dynamics import Motion
from collplan_core.time_to_goal_planner.model import STEP, Problem

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
    x, y, vx, vy, _ = motion
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
