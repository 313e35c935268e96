"""Solid inferred behind the pieces: discs around rows parallel to them, until a place there is seen to be free."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.contradiction import seen_beyond
from collplan_core.time_to_goal_planner.boundary_memory.grid import window
from collplan_core.time_to_goal_planner.boundary_memory.working import Nodes, Pool, Sight, middle


def inferred_rows(depth: float, radius: float) -> np.ndarray:
    """Returns how far behind a piece each row is [m], so that discs of `radius` block centres over a depth of `depth`.

    Empty where the disc around the piece itself reaches as deep.
    """
    deepest = depth - 2.0 * radius
    n = max(0, math.ceil(deepest / (1.5 * radius) - 1e-9))
    return deepest * np.arange(1, n + 1) / max(n, 1)


SKIN = 0.04
"""Solid inferred so little behind a surface that is seen would only hide that surface [m]."""


@njit
def _is_seen_free(piece: np.ndarray, normal: np.ndarray, rows: np.ndarray, sight: Sight) -> bool:
    """Returns whether the scan sees what would be inferred behind a piece, or a surface just in front of it."""
    x, y = middle(piece)
    farthest = -math.inf
    for row in rows:
        farthest = max(farthest, seen_beyond(sight, x - row * normal[0], y - row * normal[1]))
    return farthest > -SKIN


@njit
def _was_free(piece: np.ndarray, normal: np.ndarray, rows: np.ndarray, nodes: Nodes) -> bool:
    """Returns whether the disc was ever seen free where it covers what would be inferred, or the surface before it."""
    mx, my = middle(piece)
    reach = nodes.radius + SKIN
    for row in rows:
        x, y = mx - row * normal[0], my - row * normal[1]
        i0, i1, j0, j1 = window(nodes, x, y, x, y, reach)
        for i in range(i0, i1):
            dx = nodes.grid.x + i * nodes.grid.spacing - x
            for j in range(j0, j1):
                dy = nodes.grid.y + j * nodes.grid.spacing - y
                if nodes.free[i, j] and dx * dx + dy * dy < reach * reach:
                    return True
    return False


@njit
def is_seen_free_behind(piece: np.ndarray, normal: np.ndarray, rows: np.ndarray, sight: Sight, nodes: Nodes) -> bool:
    """Returns whether what would be inferred behind a piece is known to be free."""
    return _is_seen_free(piece, normal, rows, sight) or _was_free(piece, normal, rows, nodes)


@njit
def drop_seen_free(pool: Pool, count: int, rows: np.ndarray, sight: Sight) -> None:
    """Drops for good what is inferred where the scan sees that it is free."""
    for k in range(count):
        if pool.solid_behind[k] and _is_seen_free(pool.pieces[k], pool.normals[k], rows, sight):
            pool.solid_behind[k], pool.seen_free_behind[k] = False, True
