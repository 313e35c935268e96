"""Over which boundaries a goal can be reached. It is given up only where those that were seen leave no way."""

import numpy as np

from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Settings
from collplan_core.time_to_goal_planner.boundary_memory.clearance import ClearanceField, clearance_at, normal_at
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries
from collplan_core.time_to_goal_planner.boundary_memory.refined import only_seen, refined
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import is_reachable
from collplan_core.time_to_goal_planner.shortest_paths.narrow_way import may_lead, narrow_way
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths

CLEAR = 0.005
"""A robot measured inside a boundary is taken to be so far out of it [m]."""


def way_to_goal(
    remembered: RememberedBoundaries,
    paths: ShortestPaths,
    local_map: LocalMap,
    position: np.ndarray,
    settings: Settings,
) -> tuple[RememberedBoundaries, ShortestPaths] | None:
    """Boundaries over which the goal can be reached from a position (2,) [m], and the shortest paths over those.

    As they are where the paths lead there. Else on finer nodes, for a way too narrow for the others; else without what
    is only inferred, as they are or on finer nodes. None where what was seen leaves no way.

    Args:
        paths: over the boundaries as they are.
        local_map: that of the newest scan.
    """
    if is_reachable(paths, _outside(remembered.field, position)):
        return remembered, paths
    found = _over_finer_nodes(remembered, paths, local_map, position, settings)
    if found is not None or not remembered.solid_behind.any():
        return found
    seen = only_seen(remembered, settings.robot.radius)
    over_seen = shortest_paths(seen.field, paths.goal, position, settings)
    if is_reachable(over_seen, _outside(seen.field, position)):
        return seen, over_seen
    return _over_finer_nodes(seen, over_seen, local_map, position, settings)


def _over_finer_nodes(
    boundaries: RememberedBoundaries,
    paths: ShortestPaths,
    local_map: LocalMap,
    position: np.ndarray,
    settings: Settings,
) -> tuple[RememberedBoundaries, ShortestPaths] | None:
    """The boundaries on finer nodes and the paths over them; None where no way leads to the goal of `paths`."""
    # most goals that are closed off are so beyond doubt: then no finer nodes are filled in every cycle
    if not may_lead(boundaries.field, position, paths.goal, paths.tolerance):
        return None
    finer = refined(boundaries, local_map, position, settings)
    way = narrow_way(finer.field, position, paths.goal, paths.tolerance)
    return None if way is None else (finer, shortest_paths(finer.field, paths.goal, position, settings, way=way))


def _outside(field: ClearanceField, position: np.ndarray) -> np.ndarray:
    """The position, or where that is a little inside a boundary the nearest place that is not (2,) [m]."""
    x, y = float(position[0]), float(position[1])
    clearance = clearance_at(field.clearance, field.grid, x, y)
    if clearance >= 0.0:
        return position
    return position + (CLEAR - clearance) * np.array(normal_at(field.clearance, field.grid, x, y))
