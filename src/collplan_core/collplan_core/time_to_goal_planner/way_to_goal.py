"""Search for a way to the goal, with fewer boundaries if needed; given up only where seen ones leave no way."""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

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
from collplan_core.time_to_goal_planner.boundary_memory.working import Nodes, RememberedBoundaries, pool_of
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import is_reachable
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from collplan_core.time_to_goal_planner.tried_gaps import TriedGaps, gap_on_the_way, widened

CLEAR = 0.005
"""A robot measured inside a boundary is taken to be so far out of it [m]."""
FINER = 3
"""Cells are so many times smaller where a way is looked for that is too narrow for the others."""


class Way(NamedTuple):
    """A way to the goal."""

    boundaries: RememberedBoundaries  # boundaries over which it leads
    paths: ShortestPaths  # the shortest paths over them
    gap: np.ndarray | None = None
    """(2,) the first gap on it that measures too narrow for the disc [m]; None without one."""


def way_to_goal(
    remembered: RememberedBoundaries,
    paths: ShortestPaths,
    position: np.ndarray,
    settings: Settings,
    tried: TriedGaps | None = None,
) -> Way | None:
    """The way to the goal from a position (2,) [m]; None where what was seen leaves none.

    Over the boundaries as they are where `paths`, of these, lead there, else over smaller cells, else without what is
    only inferred, else with gaps wider by twice TIGHT, but for those that were tried planner.recovery_tries times.
    """
    radius = settings.robot.radius
    if is_reachable(paths, _outside(remembered.field, position)):
        return Way(remembered, paths)
    for seen in _with_ever_less(remembered, radius):
        over = _finer_paths(seen.field, paths.goal, position, settings)
        if over is not None:
            return Way(seen, over)
    closed = np.zeros((0, 2)) if tried is None else tried.closed(max(settings.planner.recovery_tries, 1))
    wider = replace(seen, field=widened(seen.field, closed, radius))
    over = _finer_paths(wider.field, paths.goal, position, settings)
    return None if over is None else Way(wider, over, gap_on_the_way(over, seen.field, position))


def _finer_paths(
    field: ClearanceField, goal: np.ndarray, position: np.ndarray, settings: Settings
) -> ShortestPaths | None:
    """Shortest paths over smaller cells; None where they do not lead to the goal."""
    over = shortest_paths(field, goal, position, settings, finer=FINER)
    return over if is_reachable(over, _outside(field, position)) else None


def _with_ever_less(memory: RememberedBoundaries, radius: float) -> Iterator[RememberedBoundaries]:
    yield memory
    if memory.solid_behind.any():
        yield only_seen(memory, radius)


def only_seen(memory: RememberedBoundaries, radius: float) -> RememberedBoundaries:
    """Remembered boundaries without inferred solid, for a disc of a radius [m]."""
    field, pool = memory.field, pool_of(memory, 0)
    clearance, source = np.full_like(field.clearance, FAR), np.full_like(field.source, NOTHING)
    nowhere = np.zeros(clearance.shape, bool)
    nodes = Nodes(clearance, source, nowhere, nowhere, field.grid, radius)
    renew(nodes, pool, len(pool.kept), np.zeros(0, bool), np.zeros(0, int), np.zeros(0))
    seen = replace(field, clearance=clearance, source=source)
    return replace(memory, solid_behind=np.zeros_like(memory.solid_behind), field=seen)


def _outside(field: ClearanceField, position: np.ndarray) -> np.ndarray:
    """The position, or where that is a little inside a boundary the nearest place that is not (2,) [m]."""
    x, y = float(position[0]), float(position[1])
    clearance = clearance_at(field.clearance, field.grid, x, y)
    if clearance >= 0.0:
        return position
    return position + (CLEAR - clearance) * np.array(normal_at(field.clearance, field.grid, x, y))
