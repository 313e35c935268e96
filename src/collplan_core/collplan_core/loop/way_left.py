"""Remaining distance and time to the goal, by the plan."""

import math

import numpy as np

from collplan_core.plan import Plan


def way_left(plan: Plan, goal: np.ndarray, max_speed: float) -> tuple[float, float]:
    """Way [m] and time [s] from the start of a plan to a goal (2,) [m]: along the plan, then straight at `max_speed`.

    A plan that ends before the goal knows of no detour from there on: both are then too small rather than too large.
    """
    along = float(np.hypot(*np.diff(plan.positions, axis=0).T).sum())
    beyond = math.dist(plan.positions[-1], goal)
    return along + beyond, float(plan.times[-1]) - plan.stamp + beyond / max_speed
