"""The clearance field on its grid, as pieces come and go: the minimum over all of them, in any order."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import inside
from collplan_core.local_map.record import LocalMap
from collplan_core.parameters import Remembered
from collplan_core.time_to_goal_planner.boundary_memory.clearance import (
    FAR,
    INFERRED,
    NOTHING,
    OBSERVED,
    ClearanceField,
    Grid,
)
from collplan_core.time_to_goal_planner.boundary_memory.working import Nodes, Pool, RememberedBoundaries

FIRST_SIDE = 6.0
"""Side of the square around the robot that the grid begins with [m]."""


def first_nodes(position: np.ndarray, half: float, spacing: float, radius: float) -> Nodes:
    """A square of nodes at multiples of the spacing, at least `half` to each side of the one nearest to a place."""
    return _nodes_between(*_square(position, half, spacing), spacing, radius)


def nodes_around(memory: RememberedBoundaries, local_map: LocalMap, radius: float, settings: Remembered) -> Nodes:
    """A copy of the remembered grid, which grows, and is stale where it is new, if the local map reaches its edge.

    Where it would be longer than `settings.side` it ends behind the robot.
    """
    field, position = memory.field, local_map.position
    reach = min(local_map.half_side, 0.25 * settings.side)
    last = field.origin + (np.array(field.clearance.shape) - 1) * field.spacing
    if (position - field.origin > reach).all() and (last - position > reach).all():
        grids = field.clearance.copy(), field.source.copy(), memory.free.copy(), np.zeros_like(memory.free)
        return Nodes(*grids, field.grid, radius)
    nodes = _nodes_between(*_grown(field, local_map, settings), settings.spacing, radius)
    _carry_over(nodes, field.clearance, field.source, memory.free, field.grid)
    return nodes


def _square(position: np.ndarray, half: float, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """First and last node (2,), counted from the world's origin, of the square around a place."""
    middle = np.floor(position / spacing + 0.5).astype(int)
    beside = math.ceil(half / spacing - 1e-9)
    return middle - beside, middle + beside


def _grown(field: ClearanceField, local_map: LocalMap, settings: Remembered) -> tuple[np.ndarray, np.ndarray]:
    """First and last node (2,) of the box around the grid and the robot, cut on the side that the robot leaves."""
    half = min(max(0.5 * FIRST_SIDE, 2.0 * local_map.half_side), 0.5 * settings.side)
    low, high = _square(local_map.position, half, field.spacing)
    first = np.rint(field.origin / field.spacing).astype(int)
    last = first + np.array(field.clearance.shape) - 1
    longest = max(round(settings.side / field.spacing), int((high - low).max()))
    grown_first, grown_last = np.minimum(first, low), np.maximum(last, high)
    return (
        np.where(high > last, np.maximum(grown_first, high - longest), grown_first),
        np.where(low < first, np.minimum(grown_last, low + longest), grown_last),
    )


def _nodes_between(first: np.ndarray, last: np.ndarray, spacing: float, radius: float) -> Nodes:
    shape = tuple(last - first + 1)
    clearance, source = np.full(shape, FAR), np.full(shape, NOTHING, np.int8)
    free, stale = np.zeros(shape, bool), np.ones(shape, bool)
    x, y = (first * spacing).tolist()
    return Nodes(clearance, source, free, stale, Grid(x, y, spacing), radius)


@njit
def _carry_over(nodes: Nodes, clearance: np.ndarray, source: np.ndarray, free: np.ndarray, grid: Grid) -> None:
    """Copies what an earlier grid holds to the nodes at the same places."""
    si = int(round((nodes.grid.x - grid.x) / nodes.grid.spacing))
    sj = int(round((nodes.grid.y - grid.y) / nodes.grid.spacing))
    (mx, my), (nx, ny) = nodes.free.shape, free.shape
    for i in range(max(0, -si), min(mx, nx - si)):
        for j in range(max(0, -sj), min(my, ny - sj)):
            nodes.clearance[i, j], nodes.source[i, j] = clearance[i + si, j + sj], source[i + si, j + sj]
            nodes.free[i, j], nodes.stale[i, j] = free[i + si, j + sj], False


@njit
def window(nodes: Nodes, x0: float, y0: float, x1: float, y1: float, reach: float) -> tuple[int, int, int, int]:
    """Nodes in the box that reaches beyond a piece: first and one past the last, in x and in y."""
    (nx, ny), grid = nodes.free.shape, nodes.grid
    return (
        max(0, int(math.ceil((min(x0, x1) - reach - grid.x) / grid.spacing))),
        min(nx, int(math.floor((max(x0, x1) + reach - grid.x) / grid.spacing)) + 1),
        max(0, int(math.ceil((min(y0, y1) - reach - grid.y) / grid.spacing))),
        min(ny, int(math.floor((max(y0, y1) + reach - grid.y) / grid.spacing)) + 1),
    )


@njit
def see_free(nodes: Nodes, ends: np.ndarray, x: float, y: float, half_side: float) -> None:
    """Note where the centre is free by F, its ends relative to (x, y), and where a boundary now blocks it."""
    i0, i1, j0, j1 = window(nodes, x, y, x, y, half_side + nodes.radius)
    grid = nodes.grid
    for i in range(i0, i1):
        for j in range(j0, j1):
            if nodes.clearance[i, j] < 0.0 and nodes.source[i, j] == OBSERVED:
                nodes.free[i, j] = False
            elif not nodes.free[i, j]:
                nodes.free[i, j] = inside(ends, grid.x + i * grid.spacing - x, grid.y + j * grid.spacing - y)


GUARD = 1.0 + 1e-12
"""Squares of distances this near to each other are compared by their roots."""


@njit
def _lower(nodes: Nodes, only_stale: bool, x0: float, y0: float, x1: float, y1: float, what: int) -> None:
    """Lower the clearance to that from one piece, at stale nodes alone or everywhere."""
    clearance, source, stale, grid, radius = nodes.clearance, nodes.source, nodes.stale, nodes.grid, nodes.radius
    i0, i1, j0, j1 = window(nodes, x0, y0, x1, y1, radius + FAR)
    dx, dy = x1 - x0, y1 - y0
    length2 = dx * dx + dy * dy
    inverse = 1.0 / length2 if length2 > 1e-24 else 0.0
    for i in range(i0, i1):
        ax = grid.x + i * grid.spacing - x0
        for j in range(j0, j1):
            if only_stale and not stale[i, j]:
                continue
            ay = grid.y + j * grid.spacing - y0
            along = min(1.0, max(0.0, (ax * dx + ay * dy) * inverse))
            ex, ey = ax - along * dx, ay - along * dy
            square, known = ex * ex + ey * ey, clearance[i, j] + radius
            if square > known * known * GUARD:
                continue
            here = math.sqrt(square) - radius
            if here < clearance[i, j]:
                clearance[i, j], source[i, j] = here, what
            elif here == clearance[i, j] and here < FAR and what < source[i, j]:
                source[i, j] = what


@njit
def _lower_behind(nodes: Nodes, only_stale: bool, pool: Pool, k: int, rows: np.ndarray) -> None:
    """Lower the clearance to that from the solid inferred behind a piece."""
    x0, y0, x1, y1 = pool.pieces[k]
    nx, ny = pool.normals[k]
    for row in rows:
        _lower(nodes, only_stale, x0 - row * nx, y0 - row * ny, x1 - row * nx, y1 - row * ny, INFERRED)


@njit
def _clear(nodes: Nodes, piece: np.ndarray, sx: float, sy: float) -> None:
    """Forget the clearance wherever a piece, shifted by s, may have lowered it."""
    i0, i1, j0, j1 = window(nodes, piece[0] + sx, piece[1] + sy, piece[2] + sx, piece[3] + sy, nodes.radius + FAR)
    nodes.stale[i0:i1, j0:j1] = True
    nodes.clearance[i0:i1, j0:j1] = FAR
    nodes.source[i0:i1, j0:j1] = NOTHING


@njit
def _clear_gone(
    nodes: Nodes, pool: Pool, had_solid_behind: np.ndarray, had_kinds: np.ndarray, rows: np.ndarray, box: np.ndarray
) -> None:
    """Forget the clearance from what is no more; the box (4,) x0, y0, x1, y1 grows to contain its pieces."""
    for k in range(len(had_solid_behind)):
        gone = not pool.kept[k] or pool.kinds[k] > had_kinds[k]
        if gone:
            _clear(nodes, pool.pieces[k], 0.0, 0.0)
        if had_solid_behind[k] and not (pool.kept[k] and pool.solid_behind[k]):
            for row in rows:
                _clear(nodes, pool.pieces[k], -row * pool.normals[k, 0], -row * pool.normals[k, 1])
        if gone or (had_solid_behind[k] and not pool.solid_behind[k]):
            x0, y0, x1, y1 = pool.pieces[k]
            box[0], box[1] = min(box[0], x0, x1), min(box[1], y0, y1)
            box[2], box[3] = max(box[2], x0, x1), max(box[3], y0, y1)


@njit
def _is_near(pieces: np.ndarray, k: int, box: np.ndarray, reach: float) -> bool:
    return (
        min(pieces[k, 0], pieces[k, 2]) - reach <= box[2]
        and max(pieces[k, 0], pieces[k, 2]) + reach >= box[0]
        and min(pieces[k, 1], pieces[k, 3]) - reach <= box[3]
        and max(pieces[k, 1], pieces[k, 3]) + reach >= box[1]
    )


@njit
def renew(
    nodes: Nodes, pool: Pool, count: int, had_solid_behind: np.ndarray, had_kinds: np.ndarray, rows: np.ndarray
) -> None:
    """Bring the clearance up to date; where a piece has gone it is computed anew, elsewhere lowered by the new ones.

    Args:
        count: number of pieces in the pool; the first len(had_solid_behind) of them are in the clearance already.
        had_solid_behind: which of those had inferred solid behind them there; had_kinds: of which kind they were.
        rows: distances of inferred solid behind a piece [m].
    """
    box = np.array([math.inf, math.inf, -math.inf, -math.inf])
    if nodes.stale[0, 0] or nodes.stale[-1, -1]:  # the grid has moved
        box[:] = -box
    _clear_gone(nodes, pool, had_solid_behind, had_kinds, rows, box)
    reach = 2.0 * (nodes.radius + FAR + (rows.max() if len(rows) > 0 else 0.0))
    for k in range(count):
        old = k < len(had_solid_behind)
        gained = pool.solid_behind[k] and not (old and had_solid_behind[k])
        known = old and pool.kinds[k] >= had_kinds[k]
        if not pool.kept[k] or (known and not gained and not _is_near(pool.pieces, k, box, reach)):
            continue
        x0, y0, x1, y1 = pool.pieces[k]
        _lower(nodes, known, x0, y0, x1, y1, pool.kinds[k])
        if pool.solid_behind[k]:
            _lower_behind(nodes, not gained, pool, k, rows)
