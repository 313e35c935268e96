"""What is remembered, on nodes so close together that nothing the disc fits through is lost between them.

Linear between two nodes to both sides of a narrow way, the clearance in its middle comes out too small by up to half
their spacing.
"""

import math
from dataclasses import replace

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Settings
from collplan_core.time_to_goal_planner.boundary_memory.clearance import (
    FAR,
    NOTHING,
    ClearanceField,
    Grid,
    clearance_at,
    nearest_node,
)
from collplan_core.time_to_goal_planner.boundary_memory.field import renew
from collplan_core.time_to_goal_planner.boundary_memory.grid import see_free
from collplan_core.time_to_goal_planner.boundary_memory.inferred import inferred_rows
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries
from collplan_core.time_to_goal_planner.boundary_memory.working import Nodes, pool_of

FINEST = 0.004
"""Nodes are so far apart where they may be [m]: a way that is wider holds a chain of them, however it is turned."""
MOST_NODES = 300_000
"""Where there would be more of them they are farther apart, up to half as far as those that there are: a cycle must not
take much longer in a large room."""
UNSURE = 0.75
"""Where the clearance, linear between nodes, is less than so many of their spacings below 0, the disc may fit: in the
middle of a square of them it is too small by up to half a diagonal."""


def only_seen(memory: RememberedBoundaries, radius: float) -> RememberedBoundaries:
    """What is remembered without what is only inferred, for a disc of a radius [m]."""
    field, pool = memory.field, pool_of(memory, 0)
    clearance, source = np.full_like(field.clearance, FAR), np.full_like(field.source, NOTHING)
    nowhere = np.zeros(clearance.shape, bool)
    nodes = Nodes(clearance, source, nowhere, nowhere, field.grid, radius)
    renew(nodes, pool, len(pool.kept), np.zeros(0, bool), np.zeros(0))
    seen = replace(field, clearance=clearance, source=source)
    return replace(memory, solid_behind=np.zeros_like(memory.solid_behind), field=seen)


def refined(
    memory: RememberedBoundaries, local_map: LocalMap, position: np.ndarray, settings: Settings
) -> RememberedBoundaries:
    """What is remembered on finer nodes, over all that is known and a position (2,) [m].

    Args:
        local_map: that of the newest scan, in whose free space the disc was seen to be free.
    """
    field, pool, radius = memory.field, pool_of(memory, 0), settings.robot.radius
    nodes = _nodes_over(field, position, radius)
    _take_over(nodes, field.clearance, field.source, memory.free, field.grid)
    rows = inferred_rows(settings.remembered.inferred_depth, radius)
    renew(nodes, pool, len(pool.kept), pool.solid_behind, rows)
    see_free(nodes, local_map.border, *local_map.position, local_map.half_side)
    origin = np.array([nodes.grid.x, nodes.grid.y])
    finer = ClearanceField(origin, nodes.grid.spacing, nodes.clearance, nodes.source)
    return replace(memory, free=nodes.free, field=finer)


def _nodes_over(field: ClearanceField, position: np.ndarray, radius: float) -> Nodes:
    """Nodes to be filled, with a margin in which nothing is near."""
    corners = np.vstack([position, field.known()])
    spacing = _spacing(field.spacing, np.ptp(corners, axis=0) + 2.0 * FAR)
    points = (corners - field.origin) / spacing
    margin = FAR / spacing
    first = np.floor(points.min(axis=0) - margin).astype(int)
    nx, ny = (int(n) for n in np.ceil(points.max(axis=0) + margin).astype(int) - first + 1)
    x, y = (float(value) for value in field.origin + spacing * first)
    clearance, source = np.empty((nx, ny)), np.empty((nx, ny), np.int8)
    return Nodes(clearance, source, np.empty((nx, ny), bool), np.empty((nx, ny), bool), Grid(x, y, spacing), radius)


def _spacing(between: float, sides: np.ndarray) -> float:
    """Spacing of the finer nodes over a box with sides (2,) [m]: a whole part of that between those there are."""
    parts = max(2, math.ceil(between / FINEST - 1e-9))
    while parts > 2 and float(np.prod(sides * parts / between)) > MOST_NODES:
        parts -= 1
    return between / parts


@njit
def _take_over(nodes: Nodes, clearance: np.ndarray, source: np.ndarray, free: np.ndarray, grid: Grid) -> None:
    """Fills the nodes from others farther apart; they are stale where those cannot say whether the disc touches."""
    (nx, ny), (mx, my) = nodes.free.shape, free.shape
    for i in range(nx):
        x = nodes.grid.x + i * nodes.grid.spacing
        for j in range(ny):
            y = nodes.grid.y + j * nodes.grid.spacing
            a, b = nearest_node(grid, x, y)
            here, known = clearance_at(clearance, grid, x, y), 0 <= a < mx and 0 <= b < my
            stale = -UNSURE * grid.spacing < here < 0.0
            nodes.clearance[i, j] = FAR if stale else here
            nodes.source[i, j] = source[a, b] if known and not stale else NOTHING
            nodes.free[i, j] = known and free[a, b]
            nodes.stale[i, j] = stale
    nodes.stale[0, 0] = True  # as on a grid that has moved: all pieces count, wherever they are
