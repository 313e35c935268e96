"""Solid inferred behind the pieces: discs around rows parallel to them, until a place there is seen to be free."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.remembered.contradiction import seen_beyond
from collplan_core.remembered.working import Nodes, Pool, Sight, middle


def inferred_rows(depth: float, radius: float) -> np.ndarray:
    """How far behind a piece each row is [m], so that discs of `radius` block `depth` of centres from the touching one.

    None where the disc around the piece itself reaches as deep.
    """
    deepest = depth - 2.0 * radius
    n = max(0, math.ceil(deepest / (1.5 * radius) - 1e-9))
    return deepest * np.arange(1, n + 1) / max(n, 1)


SKIN = 0.04
"""Solid inferred so little behind a surface that is seen would only hide that surface [m]."""


@njit
def is_refuted(piece: np.ndarray, normal: np.ndarray, rows: np.ndarray, sight: Sight, nodes: Nodes) -> bool:
    """Whether what would be inferred behind a piece is seen to be free, or ever was free for the disc."""
    x, y = middle(piece)
    for row in rows:
        px, py = x - row * normal[0], y - row * normal[1]
        if max(abs(px - sight.x), abs(py - sight.y)) > sight.half_side:
            continue
        if seen_beyond(sight, px, py) > -SKIN:
            return True
        i = int(math.floor((px - nodes.ox) / nodes.spacing + 0.5))
        j = int(math.floor((py - nodes.oy) / nodes.spacing + 0.5))
        if 0 <= i < nodes.free.shape[0] and 0 <= j < nodes.free.shape[1] and nodes.free[i, j]:
            return True
    return False


@njit
def refute(pool: Pool, count: int, rows: np.ndarray, sight: Sight, nodes: Nodes) -> None:
    """Drop for good what is inferred where the scan sees that it is free."""
    for k in range(count):
        if pool.backed[k] and is_refuted(pool.pieces[k], pool.normals[k], rows, sight, nodes):
            pool.backed[k], pool.refuted[k] = False, True
