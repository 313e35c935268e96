"""The clearance field as pieces come and go: the minimum over all of them, so their order does not matter."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import FAR, INFERRED, NOTHING, OBSERVED
from collplan_core.time_to_goal_planner.boundary_memory.grid import window
from collplan_core.time_to_goal_planner.boundary_memory.working import Nodes, Pool

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
            elif here == clearance[i, j] and here < FAR and what == OBSERVED:
                source[i, j] = what  # has precedence over what is inferred as near


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
def _clear_gone(nodes: Nodes, pool: Pool, had_solid_behind: np.ndarray, rows: np.ndarray, box: np.ndarray) -> None:
    """Forget the clearance from what is no more; the box (4,) x0, y0, x1, y1 grows to contain its pieces."""
    for k in range(len(had_solid_behind)):
        if not pool.kept[k]:
            _clear(nodes, pool.pieces[k], 0.0, 0.0)
        if had_solid_behind[k] and not (pool.kept[k] and pool.solid_behind[k]):
            for row in rows:
                _clear(nodes, pool.pieces[k], -row * pool.normals[k, 0], -row * pool.normals[k, 1])
        if not pool.kept[k] or (had_solid_behind[k] and not pool.solid_behind[k]):
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
def renew(nodes: Nodes, pool: Pool, count: int, had_solid_behind: np.ndarray, rows: np.ndarray) -> None:
    """Bring the clearance up to date; where a piece has gone it is computed anew, elsewhere lowered by the new ones.

    Args:
        count: number of pieces in the pool; the first len(had_solid_behind) of them are in the clearance already.
        had_solid_behind: which of those had inferred solid behind them there.
        rows: distances of inferred solid behind a piece [m].
    """
    box = np.array([math.inf, math.inf, -math.inf, -math.inf])
    if nodes.stale[0, 0] or nodes.stale[-1, -1]:  # the grid has moved
        box[:] = -box
    _clear_gone(nodes, pool, had_solid_behind, rows, box)
    reach = 2.0 * (nodes.radius + FAR + (rows.max() if len(rows) > 0 else 0.0))
    for k in range(count):
        old = k < len(had_solid_behind)
        gained = pool.solid_behind[k] and not (old and had_solid_behind[k])
        if not pool.kept[k] or (old and not gained and not _is_near(pool.pieces, k, box, reach)):
            continue
        x0, y0, x1, y1 = pool.pieces[k]
        _lower(nodes, old, x0, y0, x1, y1, OBSERVED)
        if pool.solid_behind[k]:
            _lower_behind(nodes, not gained, pool, k, rows)
