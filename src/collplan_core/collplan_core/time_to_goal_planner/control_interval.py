"""The time for which one command holds: where it leads and what it costs."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, clearance_cost, contact_cost, step
from collplan_core.time_to_goal_planner.model import KNOT_STEPS, STEP, Goal, Grid, Law, Price

ON_THE_WAY = -1.0


@njit
def roll_knot(clearance: np.ndarray, source: np.ndarray, grid: Grid, goal: Goal, law: Law, price: Price, x: float,
              y: float, vx: float, vy: float, near: float, ux: float, uy: float,
              ) -> tuple[float, float, float, float, float, float, float]:  # fmt: skip
    """KNOT under command u from a place whose clearance is at least `near`.

    Returns:
        x, y, vx, vy, what the clearance there is at least, cost [s], time of arrival within the goal's tolerance since
        the knot began [s] or ON_THE_WAY.
    """
    bx, by = x, y
    cost, touched = 0.0, False
    for k in range(KNOT_STEPS):
        px, py = x, y
        x, y, vx, vy, near, kind, into, _, _, _ = step(clearance, source, grid, law, x, y, vx, vy, near, ux, uy)
        if kind != NO_CONTACT:
            touched = True
            cost += contact_cost(price, kind, into)
        if is_there(goal, x, y):
            cost += graze_cost(goal, x, y, vx, vy)
            return x, y, vx, vy, near, cost, (k + arrival_share(goal, px, py, x, y)) * STEP
    if not touched and near <= price.distance:
        cost += clearance_cost(clearance, grid, price, bx, by, x, y, math.sqrt(vx * vx + vy * vy))
    return x, y, vx, vy, near, cost, ON_THE_WAY


@njit
def is_there(goal: Goal, x: float, y: float) -> bool:
    """Whether (x, y) is within the goal's tolerance."""
    return (x - goal.x) * (x - goal.x) + (y - goal.y) * (y - goal.y) <= goal.tolerance * goal.tolerance


@njit
def arrival_share(goal: Goal, x: float, y: float, px: float, py: float) -> float:
    """Share of a step from (x, y) to (px, py), which is within the goal's tolerance, after which it comes there."""
    before = math.sqrt((x - goal.x) * (x - goal.x) + (y - goal.y) * (y - goal.y))
    after = math.sqrt((px - goal.x) * (px - goal.x) + (py - goal.y) * (py - goal.y))
    return (before - goal.tolerance) / (before - after) if before > goal.tolerance else 0.0


@njit
def graze_cost(goal: Goal, x: float, y: float, vx: float, vy: float) -> float:
    """What an arrival at (x, y) with (vx, vy) costs for passing the goal's centre beside [s]."""
    speed2 = vx * vx + vy * vy
    if speed2 < 1e-12:
        return 0.0
    beside = vx * (goal.y - y) - vy * (goal.x - x)
    return goal.graze * beside * beside / speed2
