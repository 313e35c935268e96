"""The memory after one more scan, and the memory of a map that is given."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Remembered, Robot
from collplan_core.parameters.groups import RADIUS
from collplan_core.time_to_goal_planner.boundary_memory.clearance import FAR, OBSERVED, ClearanceField, nearest_node
from collplan_core.time_to_goal_planner.boundary_memory.contradiction import (
    count_contradictions,
    drop_seen_free,
    inferred_rows,
)
from collplan_core.time_to_goal_planner.boundary_memory.cutting import cut
from collplan_core.time_to_goal_planner.boundary_memory.field import (
    FIRST_SIDE,
    first_nodes,
    nodes_around,
    renew,
    see_free,
)
from collplan_core.time_to_goal_planner.boundary_memory.merging import merge_scan
from collplan_core.time_to_goal_planner.boundary_memory.working import (
    Nodes,
    Pool,
    RememberedBoundaries,
    Sight,
    middle,
    pool_of,
    sight_of,
)

DEEPER = 0.04
"""Depth within a mover's place from which on pieces that have stood are forgotten too: walls stand beside it [m]."""
MOST_PIECES = 20000
"""Largest number of pieces; those seen longest ago are forgotten first."""
CONTRADICTION = 0.05
"""Boundaries are forgotten if two scans in a row see this far through them [m]."""
INFERRED_DEPTH, INFERRED_INSET = 0.30, 0.08
"""Depth of the solid assumed behind a boundary, for the disc's centre, until it is seen to be free; and distance from
the ends of what was seen at which that begins. Of a robot of RADIUS, in proportion to the radius [m]."""
NO_ROWS, NONE, NO_KINDS = np.zeros(0), np.zeros(0, bool), np.zeros(0, int)


def remember(
    memory: RememberedBoundaries | None, local_map: LocalMap, robot: Robot, settings: Remembered
) -> RememberedBoundaries:
    """The memory with one more scan: shown boundaries merged, contradicted ones forgotten. The old one stays valid."""
    if memory is None:
        half = 0.5 * min(FIRST_SIDE, settings.side)
        memory = _nothing(first_nodes(local_map.position, half, settings.spacing, robot.radius))
    sight = sight_of(local_map)
    size = robot.radius / RADIUS
    rows, inset = inferred_rows(INFERRED_DEPTH * size, robot.radius), INFERRED_INSET * size
    cuts = cut(local_map.walls, local_map.wall_surface, sight, settings.spacing, inset, robot.radius)
    nodes, pool = nodes_around(memory, local_map, robot.radius, settings), pool_of(memory, len(cuts.pieces))
    count = len(memory.pieces)
    count_contradictions(pool, count, sight, CONTRADICTION)
    drop_seen_free(pool, count, rows, sight)
    _forget_outside(pool, count, nodes)
    _forget_swept(pool, count, sight.swept)
    count = merge_scan(pool, count, cuts, sight, nodes, rows, CONTRADICTION)
    _forget_oldest(pool, MOST_PIECES)
    renew(nodes, pool, count, memory.solid_behind, memory.kinds, rows)
    see_free(nodes, local_map.border, *local_map.position, local_map.half_side)
    return _record(pool, nodes)


def known_boundaries(walls: np.ndarray, center: np.ndarray, robot: Robot, settings: Remembered) -> RememberedBoundaries:
    """A memory of a given map: all walls (w, 4), never forgotten, nothing inferred, free wherever nothing is touched.

    Walls are x0, y0, x1, y1 [m]; the grid, as large as they need, has its centre at `center` (2,) [m].
    """
    walls = np.ascontiguousarray(walls, dtype=float).reshape(-1, 4)
    far = np.abs(walls.reshape(-1, 2) - center).max(initial=0.0) + robot.radius + FAR
    nodes = first_nodes(np.asarray(center), max(0.5 * FIRST_SIDE, far), settings.spacing, robot.radius)
    no, x, y = np.zeros((0, 3)), float(center[0]), float(center[1])
    everywhere = Sight(np.zeros(0), x, y, 0.0, 0.0, no, math.inf, math.inf, NONE, no)
    cuts = cut(walls, np.arange(len(walls)), everywhere, settings.spacing, math.inf, 0.0)
    pool = pool_of(_nothing(nodes), len(cuts.pieces))
    pool.pieces[:], pool.normals[:], pool.seen[:], pool.kept[:] = cuts.pieces, cuts.normals, math.inf, True
    pool.kinds[:] = OBSERVED
    renew(nodes, pool, len(cuts.pieces), NONE, NO_KINDS, NO_ROWS)
    nodes.free[:] = nodes.clearance >= 0.0
    return _record(pool, nodes)


def _nothing(nodes: Nodes) -> RememberedBoundaries:
    no, times = NONE, np.zeros(0, np.int8)
    return _record(Pool(np.zeros((0, 4)), np.zeros((0, 2)), no, no, np.zeros(0), times, NO_KINDS, no, no), nodes)


@njit
def _forget_outside(pool: Pool, count: int, nodes: Nodes) -> None:
    """Forgets what lies outside of the grid."""
    (nx, ny), grid = nodes.free.shape, nodes.grid
    for k in range(count):
        mx, my = middle(pool.pieces[k])
        i, j = nearest_node(grid, mx, my)
        if not (0 <= i < nx and 0 <= j < ny):
            pool.kept[k] = False


@njit
def _forget_swept(pool: Pool, count: int, swept: np.ndarray) -> None:
    """Forgets what lies where movers were lately: it was a mover's, before that was known."""
    for k in range(count):
        x, y = middle(pool.pieces[k])
        for m in range(len(swept)):
            reach = swept[m, 2] - (DEEPER if pool.kinds[k] == OBSERVED else 0.0)
            if (x - swept[m, 0]) ** 2 + (y - swept[m, 1]) ** 2 < reach * reach:
                pool.kept[k] = False


def _forget_oldest(pool: Pool, most: int) -> None:
    """Let go of the pieces seen longest ago, of those equally old the first."""
    kept = np.flatnonzero(pool.kept)
    if len(kept) > most:
        pool.kept[kept[np.argsort(pool.seen[kept], kind="stable")[: len(kept) - most]]] = False


def _record(pool: Pool, nodes: Nodes) -> RememberedBoundaries:
    kept = pool.kept
    field = ClearanceField(np.array([nodes.grid.x, nodes.grid.y]), nodes.grid.spacing, nodes.clearance, nodes.source)
    return RememberedBoundaries(
        pool.pieces[kept],
        pool.normals[kept],
        pool.solid_behind[kept],
        pool.seen[kept],
        nodes.free,
        field,
        pool.seen_free_behind[kept],
        pool.times_contradicted[kept],
        pool.kinds[kept],
    )
