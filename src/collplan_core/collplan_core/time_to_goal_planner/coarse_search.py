"""Coarse plans: one velocity for a while, then another, up to the horizon."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.control_interval import arrival_share, graze_cost, is_there
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, contact_cost, step
from collplan_core.time_to_goal_planner.model import STEP, Goal, Grid, Law, Price, Scene
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import heading, time_to_go
from collplan_core.time_to_goal_planner.stopping import UNSTOPPABLE, admits_stop

SWITCH_STEPS = np.array([4, 10, 18, 28, 40])
"""Steps after which the first velocity is exchanged for the second."""
STOP_TEST_STEPS = 4
"""Steps after which the robot must be able to brake within what was seen, where that is asked for."""


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
def to_go(scene: Scene, law: Law, x: float, y: float, vx: float, vy: float) -> float:
    """Time to go from here over what is known [s]."""
    return time_to_go(
        scene.waypoint, scene.waypoints, scene.onward, scene.remaining, scene.turning, scene.gx, scene.gy,
        scene.cell, scene.goal.x, scene.goal.y, scene.goal.tolerance, law.max_speed, law.max_acceleration, x, y, vx, vy,
    )  # fmt: skip


@njit
def toward(scene: Scene, x: float, y: float) -> tuple[float, float, float]:
    """Unit direction to the first way point from here, and the distance to it [m]."""
    return heading(
        scene.waypoint, scene.waypoints, scene.onward, scene.remaining, scene.gx, scene.gy, scene.cell, x, y,
    )  # fmt: skip


@njit
def _roll(clearance: np.ndarray, source: np.ndarray, grid: Grid, goal: Goal, law: Law, price: Price, state: np.ndarray,
          ux: float, uy: float, first: int, last: int) -> tuple[bool, float]:  # fmt: skip
    """Steps first to last under u, in place on state (x, y, vx, vy, near, cost); whether the goal is reached, when."""
    x, y, vx, vy, near, cost = state[0], state[1], state[2], state[3], state[4], state[5]
    arrived, time = False, 0.0
    for k in range(first, last):
        px, py = x, y
        x, y, vx, vy, near, kind, into, _, _, _ = step(clearance, source, grid, law, x, y, vx, vy, near, ux, uy)
        if kind != NO_CONTACT:
            cost += contact_cost(price, kind, into)
        if is_there(goal, x, y):
            arrived, time = True, (k + arrival_share(goal, px, py, x, y)) * STEP
            cost += graze_cost(goal, x, y, vx, vy)
            break
    state[0], state[1], state[2], state[3], state[4], state[5] = x, y, vx, vy, near, cost
    return arrived, time


@njit
def coarse_plans(scene: Scene, law: Law, price: Price, begin: np.ndarray, n_steps: int, stop_test: bool,
                 ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Every pair of targets with every time of the switch.

    Args:
        begin: (6,) x, y, vx, vy, clearance there at least, cost so far.
        n_steps: the horizon.

    Returns:
        targets (25, 2); J (25, 5, 25) [s] by first target, switch and second target; ends (25, 5, 25, 4).
    """
    clearance, source, grid, goal = scene.clearance, scene.source, scene.grid, scene.goal
    ux, uy, _ = toward(scene, begin[0], begin[1])
    velocities = targets(math.atan2(uy, ux), law.max_speed)
    n, m = len(velocities), len(SWITCH_STEPS)
    j = np.full((n, m, n), np.inf)
    ends = np.zeros((n, m, n, 4))
    state, branch = np.empty(6), np.empty(6)
    for a in range(n):
        state[:] = begin
        begun, extra = 0, 0.0
        for b in range(m):
            switch = min(SWITCH_STEPS[b], n_steps)
            arrived, time = _roll(
                clearance, source, grid, goal, law, price, state, velocities[a, 0], velocities[a, 1], begun, switch
            )
            if arrived:
                j[a, b, a] = time + state[5] + extra
                ends[a, b, a] = state[:4]
                break
            if (
                begun < STOP_TEST_STEPS <= switch
                and stop_test
                and not admits_stop(scene, law, state[0], state[1], state[2], state[3])
            ):
                extra = UNSTOPPABLE
            begun = switch
            for c in range(n):
                if c == a and b < m - 1:  # the same rollout comes with the last switch
                    continue
                branch[:] = state
                arrived, time = _roll(
                    clearance,
                    source,
                    grid,
                    goal,
                    law,
                    price,
                    branch,
                    velocities[c, 0],
                    velocities[c, 1],
                    begun,
                    n_steps,
                )
                if not arrived:
                    time = n_steps * STEP + to_go(scene, law, branch[0], branch[1], branch[2], branch[3])
                j[a, b, c] = time + branch[5] + extra
                ends[a, b, c] = branch[:4]
    return velocities, j, ends
