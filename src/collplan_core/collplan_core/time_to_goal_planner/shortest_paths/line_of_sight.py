"""Line of sight: whether the disc's centre can move along a straight line."""

import math

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at
from collplan_core.time_to_goal_planner.shortest_paths.grid import Cells

CORNER_CUT = 0.0025
"""A line may cut a rounded corner by so much: what the line between two neighbouring free cells can cut [m]."""
SHORTEST_STEP = 0.02
"""Along a boundary the line is looked at in steps of this length [m]."""


@njit
def sees(cells: Cells, a: int, b: int) -> bool:
    """Returns whether the line from cell a to cell b (flat indices) is free.

    Nothing is nearer than its clearance, so as much of the line is stepped over.
    """
    my = cells.blocked.shape[1]
    x, y = cells.x + (a // my) * cells.spacing, cells.y + (a % my) * cells.spacing
    dx, dy = (b // my - a // my) * cells.spacing, (b % my - a % my) * cells.spacing
    distance = math.hypot(dx, dy)
    along = 0.0
    while along < distance:
        share = along / distance
        clearance = clearance_at(cells.clearance, cells.grid, x + share * dx, y + share * dy)
        if clearance < -CORNER_CUT:
            return False
        along += max(clearance, SHORTEST_STEP)
    return True
