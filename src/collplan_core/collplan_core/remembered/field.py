"""The clearance field as pieces come and go: the minimum over all of them, so their order does not matter."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.remembered.clearance import FAR, INFERRED, NOTHING, OBSERVED
from collplan_core.remembered.grid import window
from collplan_core.remembered.working import Nodes, Pool

GUARD = 1.0 + 1e-12
"""Squares of distances this near to each other are told apart by their roots."""


@njit
def _lower(nodes: Nodes, everywhere: bool, piece: np.ndarray, what: int) -> None:
    """Lower the clearance to that from one piece, everywhere or at stale nodes alone."""
    i0, i1, j0, j1 = window(nodes, piece, nodes.radius + FAR)
    x0, y0, dx, dy = piece[0], piece[1], piece[2] - piece[0], piece[3] - piece[1]
    length2 = dx * dx + dy * dy
    inverse = 1.0 / length2 if length2 > 1e-24 else 0.0
    for i in range(i0, i1):
        ax = nodes.ox + i * nodes.spacing - x0
        for j in range(j0, j1):
            if not everywhere and not nodes.stale[i, j]:
                continue
            ay = nodes.oy + j * nodes.spacing - y0
            along = min(1.0, max(0.0, (ax * dx + ay * dy) * inverse))
            ex, ey = ax - along * dx, ay - along * dy
            square, known = ex * ex + ey * ey, nodes.clearance[i, j] + nodes.radius
            if square <= known * known * GUARD:
                _lower_node(nodes, i, j, math.sqrt(square) - nodes.radius, what)


@njit
def _lower_node(nodes: Nodes, i: int, j: int, clearance: float, what: int) -> None:
    """What was observed has precedence over what is inferred as near."""
    known = nodes.clearance[i, j]
    if clearance < known:
        nodes.clearance[i, j], nodes.source[i, j] = clearance, what
    elif clearance == known and clearance < FAR and what == OBSERVED:
        nodes.source[i, j] = what


@njit
def _shifted(piece: np.ndarray, normal: np.ndarray, row: float) -> np.ndarray:
    sx, sy = row * normal[0], row * normal[1]
    return np.array([piece[0] - sx, piece[1] - sy, piece[2] - sx, piece[3] - sy])


@njit
def _make_stale(nodes: Nodes, piece: np.ndarray) -> None:
    i0, i1, j0, j1 = window(nodes, piece, nodes.radius + FAR)
    nodes.stale[i0:i1, j0:j1] = True


@njit
def _find_stale(nodes: Nodes, pool: Pool, was_backed: np.ndarray, rows: np.ndarray) -> None:
    """Mark the nodes that pieces which are no more may have lowered."""
    for k in range(len(was_backed)):
        if not pool.kept[k]:
            _make_stale(nodes, pool.pieces[k])
        if was_backed[k] and not (pool.kept[k] and pool.backed[k]):
            for row in rows:
                _make_stale(nodes, _shifted(pool.pieces[k], pool.normals[k], row))


@njit
def _clear_stale(nodes: Nodes) -> np.ndarray:
    """(4,) the box of the stale nodes, x0, y0, x1, y1 [m], which are cleared; x0 > x1 where there are none."""
    box = np.array([math.inf, math.inf, -math.inf, -math.inf])
    for i in range(nodes.stale.shape[0]):
        for j in range(nodes.stale.shape[1]):
            if nodes.stale[i, j]:
                nodes.clearance[i, j], nodes.source[i, j] = FAR, NOTHING
                x, y = nodes.ox + i * nodes.spacing, nodes.oy + j * nodes.spacing
                box[0], box[1], box[2], box[3] = min(box[0], x), min(box[1], y), max(box[2], x), max(box[3], y)
    return box


@njit
def _reaches(piece: np.ndarray, box: np.ndarray, reach: float) -> bool:
    return (
        min(piece[0], piece[2]) - reach <= box[2]
        and max(piece[0], piece[2]) + reach >= box[0]
        and min(piece[1], piece[3]) - reach <= box[3]
        and max(piece[1], piece[3]) + reach >= box[1]
    )


@njit
def renew(nodes: Nodes, pool: Pool, count: int, was_backed: np.ndarray, rows: np.ndarray) -> None:
    """Bring the clearance up to date.

    Args:
        count: of pieces in the pool; the first len(was_backed) of them are in the clearance already.
        was_backed: which of those had inferred solid behind them there.
        rows: how far behind a piece that is [m].
    """
    _find_stale(nodes, pool, was_backed, rows)
    stale = _clear_stale(nodes)
    reach = nodes.radius + FAR
    for k in range(count):
        if not pool.kept[k]:
            continue
        new = k >= len(was_backed)
        if new or _reaches(pool.pieces[k], stale, reach):
            _lower(nodes, new, pool.pieces[k], OBSERVED)
        if pool.backed[k]:
            new = new or not was_backed[k]
            for row in rows:
                behind = _shifted(pool.pieces[k], pool.normals[k], row)
                if new or _reaches(behind, stale, reach):
                    _lower(nodes, new, behind, INFERRED)
