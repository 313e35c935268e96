"""The shortest paths to a goal over a clearance field."""

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.time_to_goal_planner.boundary_memory.clearance import ClearanceField
from collplan_core.time_to_goal_planner.shortest_paths.grid import Cells, cells_around
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.wavefront import front_over, spread
from collplan_core.time_to_goal_planner.shortest_paths.waypoints import find_waypoints, turns


def shortest_paths(
    field: ClearanceField,
    goal: np.ndarray,
    around: np.ndarray,
    settings: Settings,
    earlier: ShortestPaths | None = None,
    finer: int = 1,
) -> ShortestPaths:
    """Any-angle shortest paths of the disc's centre to the goal (2,) [m]; what the field does not know is free.

    Args:
        around: (2,) where the robot is; the cells cover it, the goal and everything known [m].
        earlier: returned as it is where goal and blocked cells are the same.
        finer: cells are so many times smaller than `time_to_goal.grid_spacing`.
    """
    spacing, tolerance = settings.time_to_goal.grid_spacing / finer, settings.planner.goal_tolerance
    goal = np.array(goal, dtype=float)
    cells, goal_cell = cells_around(field, goal, np.asarray(around, dtype=float), spacing)
    if earlier is not None and _same(earlier, goal, tolerance, cells):
        return earlier
    front = front_over(cells.blocked.size)
    n = spread(cells, front, goal_cell, tolerance / cells.spacing)
    waypoint, points, before = find_waypoints(front.parent, front.order[:n], cells, goal_cell)
    onward, remaining, turning = turns(points, before)
    shape = cells.blocked.shape
    return ShortestPaths(
        np.array([cells.x, cells.y]),
        cells.spacing,
        cells.blocked,
        cells.spacing * front.length.reshape(shape),
        waypoint.reshape(shape),
        points,
        onward,
        remaining,
        turning,
        goal,
        tolerance,
    )


def _same(earlier: ShortestPaths, goal: np.ndarray, tolerance: float, cells: Cells) -> bool:
    return bool(
        np.array_equal(earlier.goal, goal)
        and earlier.tolerance == tolerance
        and earlier.spacing == cells.spacing
        and np.array_equal(earlier.origin, (cells.x, cells.y))
        and np.array_equal(earlier.blocked, cells.blocked)
    )
