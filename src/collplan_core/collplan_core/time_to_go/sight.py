"""Whether the disc's centre can move along a straight line."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.remembered.clearance import clearance_at

GRAZE = 0.0025
"""A line may cut a rounded corner by so much: what the line between two neighbouring free cells can cut [m]."""
SHORTEST_STEP = 0.01
"""Along a boundary the line is looked at in steps of this length [m]."""


@njit
def sees(
    clearance: np.ndarray, ox: float, oy: float, spacing: float, ax: float, ay: float, bx: float, by: float
) -> bool:
    """Whether the line from a to b is free: nothing is nearer than its clearance, so as much is stepped over."""
    distance = math.hypot(bx - ax, by - ay)
    if distance == 0.0:
        return True
    ux, uy = (bx - ax) / distance, (by - ay) / distance
    along = 0.0
    while along < distance:
        near = clearance_at(clearance, ox, oy, spacing, ax + along * ux, ay + along * uy)
        if near < -GRAZE:
            return False
        along += max(near, SHORTEST_STEP)
    return True
