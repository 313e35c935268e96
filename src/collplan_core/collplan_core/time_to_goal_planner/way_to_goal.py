"""Search for a way to the goal, with fewer boundaries if needed; given up only where seen ones leave no way."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.time_to_goal_planner.boundary_memory.clearance import (
    FAR,
    NOTHING,
    ClearanceField,
    clearance_at,
    normal_at,
)
from collplan_core.time_to_goal_planner.boundary_memory.field import renew
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries
from collplan_core.time_to_goal_planner.boundary_memory.working import Nodes, pool_of
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import is_reachable
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths

CLEAR = 0.005
"""A robot measured inside a boundary is taken to be so far out of it [m]."""
FINER = 3
"""Cells are so many times smaller where a way is looked for that is too narrow for the others."""
TIGHT = 0.01
"""Last, boundaries count as so much farther away: a gap that the disc just fits through may measure narrower [m]."""


def way_to_goal(
    remembered: RememberedBoundaries, paths: ShortestPaths, position: np.ndarray, settings: Settings
) -> tuple[RememberedBoundaries, ShortestPaths] | None:
    """Boundaries over which the goal can be reached from a position (2,) [m], and the shortest paths over those.

    As they are where the paths lead there, else over smaller cells, else without what is only inferred, else with gaps
    wider by 2 TIGHT. None where what was seen leaves no way even then.

    Args:
        paths: over the boundaries as they are.
    """
    if is_reachable(paths, _outside(remembered.field, position)):
        return remembered, paths
    for boundaries in _with_ever_less(remembered, settings.robot.radius):
        over = shortest_paths(boundaries.field, paths.goal, position, settings, finer=FINER)
        if is_reachable(over, _outside(boundaries.field, position)):
            return boundaries, over
    return None


def _with_ever_less(memory: RememberedBoundaries, radius: float) -> Iterator[RememberedBoundaries]:
    yield memory
    if memory.solid_behind.any():
        memory = only_seen(memory, radius)
        yield memory
    field = memory.field
    yield replace(memory, field=replace(field, clearance=field.clearance + TIGHT))


def only_seen(memory: RememberedBoundaries, radius: float) -> RememberedBoundaries:
    """Remembered boundaries without inferred solid, for a disc of a radius [m]."""
    field, pool = memory.field, pool_of(memory, 0)
    clearance, source = np.full_like(field.clearance, FAR), np.full_like(field.source, NOTHING)
    nowhere = np.zeros(clearance.shape, bool)
    nodes = Nodes(clearance, source, nowhere, nowhere, field.grid, radius)
    renew(nodes, pool, len(pool.kept), np.zeros(0, bool), np.zeros(0))
    seen = replace(field, clearance=clearance, source=source)
    return replace(memory, solid_behind=np.zeros_like(memory.solid_behind), field=seen)


def _outside(field: ClearanceField, position: np.ndarray) -> np.ndarray:
    """The position, or where that is a little inside a boundary the nearest place that is not (2,) [m]."""
    x, y = float(position[0]), float(position[1])
    clearance = clearance_at(field.clearance, field.grid, x, y)
    if clearance >= 0.0:
        return position
    return position + (CLEAR - clearance) * np.array(normal_at(field.clearance, field.grid, x, y))
