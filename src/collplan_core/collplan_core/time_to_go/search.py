"""The shortest paths to a goal over a clearance field."""

import numpy as np

from collplan_core.params import Settings
from collplan_core.remembered.clearance import ClearanceField
from collplan_core.time_to_go.grid import blocked_cells, cells_around
from collplan_core.time_to_go.record import ShortestPaths
from collplan_core.time_to_go.spread import spread
from collplan_core.time_to_go.waypoints import turns, way_points


def shortest_paths(field: ClearanceField, goal: np.ndarray, around: np.ndarray, settings: Settings,
                   earlier: ShortestPaths | None = None) -> ShortestPaths:  # fmt: skip
    """Any-angle shortest paths of the disc's centre to the goal; what the field does not know is free.

    Args:
        field: clearance of the disc's centre, world frame.
        goal: (2,) [m].
        around: (2,) where the robot is; the cells cover it, the goal and everything known [m].
        earlier: returned as it is where goal and blocked cells are the same.
    """
    spacing, tolerance = settings.time_to_goal.grid_spacing, settings.planner.goal_tolerance
    goal = np.array(goal, dtype=float)
    first, last, spacing = cells_around(field, goal, np.asarray(around, dtype=float), spacing)
    origin = goal + spacing * first
    mx, my = (int(m) for m in last - first + 1)
    of_field = (float(field.origin[0]), float(field.origin[1]), field.spacing)
    of_cells = (float(origin[0]), float(origin[1]), spacing)
    blocked = blocked_cells(field.clearance, *of_field, *of_cells, mx, my)
    if earlier is not None and _same(earlier, goal, tolerance, origin, spacing, blocked):
        return earlier
    source = _source(blocked, -first, tolerance / spacing)
    length, parent, order, n = spread(blocked, source, field.clearance, *of_field, *of_cells)
    waypoint, points, before = way_points(parent, order, n, my, *of_cells)
    if n == 0:
        points, before = goal[None, :], np.array([-1], dtype=np.int32)
    robot = settings.robot
    onward, remaining, turning = turns(points, before, robot.max_speed, robot.max_acceleration)
    return ShortestPaths(
        origin, spacing, blocked, length.reshape(mx, my), waypoint.reshape(mx, my), points, onward, remaining, turning,
        goal, tolerance,
    )  # fmt: skip


def _same(earlier: ShortestPaths, goal: np.ndarray, tolerance: float, origin: np.ndarray, spacing: float,
          blocked: np.ndarray) -> bool:  # fmt: skip
    return bool(
        np.array_equal(earlier.goal, goal)
        and earlier.tolerance == tolerance
        and earlier.spacing == spacing
        and np.array_equal(earlier.origin, origin)
        and np.array_equal(earlier.blocked, blocked)
    )


def _source(blocked: np.ndarray, goal: np.ndarray, reach: float) -> int:
    """Flat index of the free cell nearest to the goal's and within reach of it [cells], -1 without."""
    my = blocked.shape[1]
    if not blocked[tuple(goal)]:
        return int(goal[0] * my + goal[1])
    i, j = np.nonzero(~blocked)
    distance = np.hypot(i - goal[0], j - goal[1])
    nearest = int(np.argmin(distance)) if len(i) else -1
    return int(i[nearest] * my + j[nearest]) if nearest >= 0 and distance[nearest] <= reach else -1
