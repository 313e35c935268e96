"""Whole plans: a command for each knot up to the goal, where they lead and what they cost."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at
from collplan_core.time_to_goal_planner.coarse_search import STOP_TEST_STEPS, to_go, toward
from collplan_core.time_to_goal_planner.control_interval import ON_THE_WAY, roll_knot
from collplan_core.time_to_goal_planner.model import KNOT, KNOT_STEPS, Law, Price, Scene
from collplan_core.time_to_goal_planner.stopping import UNSTOPPABLE, admits_stop

LATE = 0.3
"""Charged beyond the time to go to a plan that does not reach the goal [s]."""
STOP_TEST_KNOT = STOP_TEST_STEPS // KNOT_STEPS
EXTENSION_TARGETS = 12
"""Bearings tried at each step of an extension to the goal, and rest."""
EXTENSION_KNOTS, EXTENSION_TRIED = 2, 4
"""Knots taken with the best of them, and knots tried."""


@njit
def clip(ux: float, uy: float, max_speed: float) -> tuple[float, float]:
    """A velocity shortened to max_speed."""
    speed = math.sqrt(ux * ux + uy * uy)
    return (ux * max_speed / speed, uy * max_speed / speed) if speed > max_speed else (ux, uy)


@njit
def near_at(scene: Scene, x: float, y: float) -> float:
    """The clearance at (x, y)."""
    return clearance_at(scene.clearance, scene.grid.ox, scene.grid.oy, scene.grid.spacing, x, y)


@njit
def end_cost(scene: Scene, law: Law, state: np.ndarray) -> float:
    """What a plan that ends at a state (x, y, vx, vy) before the goal is charged for the rest [s]."""
    return to_go(scene, law, state[0], state[1], state[2], state[3]) + LATE


@njit
def stop_cost(scene: Scene, law: Law, state: np.ndarray) -> float:
    """Charged where the robot cannot brake from a state (x, y, vx, vy) within what it has seen [s]."""
    return 0.0 if admits_stop(scene, law, state[0], state[1], state[2], state[3]) else UNSTOPPABLE


@njit
def roll(scene: Scene, law: Law, price: Price, stop_test: bool, commands: np.ndarray, n: int, states: np.ndarray,
         costs: np.ndarray) -> tuple[int, float, bool]:  # fmt: skip
    """Fills states (n + 1, 4) and costs so far (n + 1,) from states[0] on.

    Returns:
        knots used, J [s], whether the goal is reached.
    """
    clearance, source, grid, goal = scene.clearance, scene.source, scene.grid, scene.goal
    x, y, vx, vy = states[0]
    near = near_at(scene, x, y)
    costs[0] = 0.0
    for k in range(n):
        x, y, vx, vy, near, cost, arrival = roll_knot(
            clearance, source, grid, goal, law, price, x, y, vx, vy, near, commands[k, 0], commands[k, 1]
        )
        states[k + 1, 0], states[k + 1, 1], states[k + 1, 2], states[k + 1, 3] = x, y, vx, vy
        costs[k + 1] = costs[k] + cost
        if stop_test and k + 1 == STOP_TEST_KNOT:
            costs[k + 1] += stop_cost(scene, law, states[k + 1])
        if arrival != ON_THE_WAY:
            return k + 1, k * KNOT + arrival + costs[k + 1], True
    return n, n * KNOT + costs[n] + end_cost(scene, law, states[n]), False


@njit
def extend(scene: Scene, law: Law, price: Price, commands: np.ndarray, n: int, end: np.ndarray) -> int:
    """Continues commands[:n], which end at state `end` (4,), greedily by the time to go; knots there are then."""
    clearance, source, grid, goal = scene.clearance, scene.source, scene.grid, scene.goal
    x, y, vx, vy = end
    near = near_at(scene, x, y)
    most = len(commands)
    while n < most:
        ux, uy, _ = toward(scene, x, y)
        bearing = math.atan2(uy, ux)
        best, bx, by = np.inf, 0.0, 0.0
        for a in range(EXTENSION_TARGETS + 1):
            if a < EXTENSION_TARGETS:
                angle = bearing + 2.0 * math.pi * a / EXTENSION_TARGETS
                tx, ty = law.max_speed * math.cos(angle), law.max_speed * math.sin(angle)
            else:
                tx, ty = 0.0, 0.0
            px, py, pvx, pvy, pnear, total = x, y, vx, vy, near, 0.0
            arrived = False
            for k in range(EXTENSION_TRIED):
                px, py, pvx, pvy, pnear, cost, arrival = roll_knot(
                    clearance, source, grid, goal, law, price, px, py, pvx, pvy, pnear, tx, ty
                )
                total += cost
                if arrival != ON_THE_WAY:
                    total += k * KNOT + arrival
                    arrived = True
                    break
            if not arrived:
                total += EXTENSION_TRIED * KNOT + to_go(scene, law, px, py, pvx, pvy)
            if total < best:
                best, bx, by = total, tx, ty
        for _ in range(EXTENSION_KNOTS):
            if n == most:
                return n
            commands[n, 0], commands[n, 1] = bx, by
            n += 1
            x, y, vx, vy, near, _, arrival = roll_knot(
                clearance, source, grid, goal, law, price, x, y, vx, vy, near, bx, by
            )
            if arrival != ON_THE_WAY:
                return n
    return n
