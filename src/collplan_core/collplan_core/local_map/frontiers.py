"""Frontiers B_i of the free space, where it borders on what is unseen but may be free. Paper: II-A.

Shadow edges, from the near end of an occluding surface to whatever lies behind it, and visible runs of the map border.
Points relative to the centre of F.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import MAP_BORDER, UNSEEN_SURFACE, FreeSpace

SHADOW_EDGE, BORDER_RUN = 0, 1
ALONG = 0.1  # sine of the angle within which a step counts as along a face


class Frontiers(NamedTuple):
    """Straight frontier segments, counter-clockwise around the centre."""

    segments: np.ndarray  # (m, 4) x0, y0, x1, y1 [m]
    kind: np.ndarray  # (m,) SHADOW_EDGE or BORDER_RUN
    number: np.ndarray  # (m,) the frontier B_i a segment belongs to
    open_side: np.ndarray  # (m, 2) whether F is seen to be open on its clockwise, on its counter-clockwise side


@njit
def _goes_on(free: FreeSpace, k: int, j: int) -> bool:
    """Returns whether the straight face at k goes on to j: a wall along the beam, seen on or cut by the map border."""
    _, border, surface, normals, straight = free
    if not straight[k] or not (surface[j] == surface[k] or surface[j] == MAP_BORDER):
        return False
    dx, dy = border[j, 0] - border[k, 0], border[j, 1] - border[k, 1]
    off = dx * normals[k, 0] + dy * normals[k, 1]
    if surface[j] == MAP_BORDER:  # the map ends before direction j meets the face's line, or the face itself has ended
        return off >= -0.005 * math.hypot(dx, dy) - 1e-4
    return abs(off) <= ALONG * math.hypot(dx, dy) + 1e-4


@njit
def _bends_away(free: FreeSpace, nearer: int, farther: int) -> bool:
    """Returns whether a step along one surface is a chord of its convex side, as on a corner seen along the beam."""
    _, border, surface, normals, _ = free
    if surface[nearer] != surface[farther]:
        return False
    dx, dy = border[farther, 0] - border[nearer, 0], border[farther, 1] - border[nearer, 1]
    falls = dx * normals[nearer, 0] + dy * normals[nearer, 1]
    rises = dx * normals[farther, 0] + dy * normals[farther, 1]
    return falls <= 1e-6 and rises >= -1e-6


@njit
def _is_one_surface(free: FreeSpace, k: int, j: int) -> bool:
    """Returns whether a steep step between directions k and j is one surface all the same."""
    nearer, farther = (k, j) if free.reach[k] < free.reach[j] else (j, k)
    return _bends_away(free, nearer, farther) or _goes_on(free, k, j) or _goes_on(free, j, k)


@njit
def find_shadow_edges(free: FreeSpace, grazing: float) -> np.ndarray:
    """(n,) whether the border of F jumps between directions k and k + 1 by more than one surface can explain."""
    reach, border, surface, _, _ = free
    n = len(reach)
    step = 2.0 * math.pi / n
    steepest = math.sin(step) / math.sin(max(grazing, 1.5 * step) - step)
    shadow = np.zeros(n, np.bool_)
    for k in range(n):
        j = (k + 1) % n
        if surface[k] == UNSEEN_SURFACE or surface[j] == UNSEEN_SURFACE or (surface[k] == MAP_BORDER == surface[j]):
            continue
        across = math.hypot(border[j, 0] - border[k, 0], border[j, 1] - border[k, 1])
        if across > min(reach[k], reach[j]) * steepest + 1e-6:
            shadow[k] = not _is_one_surface(free, k, j)
    return shadow


@njit
def _corner_between(ax: float, ay: float, bx: float, by: float, box: np.ndarray) -> tuple[bool, float, float]:
    """The corner of the box that a run of its border passes between two neighbouring points on it."""
    for k in range(4):
        cx = box[0] if k < 2 else box[2]
        cy = box[1] if k % 2 == 0 else box[3]
        if ax * cy - ay * cx > 1e-12 and cx * by - cy * bx > 1e-12 and ax * cx + ay * cy > 0.0:
            return True, cx, cy
    return False, 0.0, 0.0


@njit
def _on_side(ax: float, ay: float, bx: float, by: float) -> bool:
    """Returns whether two points of the box's border lie on one side of it."""
    return abs(ax - bx) < 1e-9 or abs(ay - by) < 1e-9


@njit
def find_frontiers(free: FreeSpace, shadow: np.ndarray, box: np.ndarray) -> Frontiers:
    """The frontiers B_i of F: shadow edges (n,) and the visible runs of the map's border, `box` (4,). Paper: II-A."""
    reach, border, surface, _, _ = free
    n = len(reach)
    segments = np.empty((2 * n + 8, 4))
    kind = np.empty(2 * n + 8, np.int64)
    number = np.empty(2 * n + 8, np.int64)
    open_side = np.empty((2 * n + 8, 2), np.bool_)
    m, frontier = 0, 0
    start = 0
    while start < n and surface[start] == MAP_BORDER and surface[start - 1] == MAP_BORDER:
        start += 1
    start %= n
    open_run = False
    for i in range(n):
        k, j = (start + i) % n, (start + i + 1) % n
        ax, ay = border[k]
        bx, by = border[j]
        if surface[k] == MAP_BORDER and surface[j] == MAP_BORDER:
            turned, cx, cy = _corner_between(ax, ay, bx, by, box)
            if turned and not _on_side(ax, ay, bx, by):
                parts = ((ax, ay, cx, cy), (cx, cy, bx, by))
            else:
                parts = ((ax, ay, bx, by), (bx, by, bx, by))
            for p in range(2):
                x0, y0, x1, y1 = parts[p]
                if x0 == x1 and y0 == y1:
                    continue
                if open_run and kind[m - 1] == BORDER_RUN and _on_side(segments[m - 1, 0], segments[m - 1, 1], x1, y1):
                    segments[m - 1, 2], segments[m - 1, 3] = x1, y1
                else:
                    segments[m, 0], segments[m, 1], segments[m, 2], segments[m, 3] = x0, y0, x1, y1
                    kind[m], number[m] = BORDER_RUN, frontier
                    open_side[m, 0], open_side[m, 1] = True, True
                    m += 1
                open_run = True
            continue
        if open_run:
            frontier += 1
            open_run = False
        if shadow[k]:
            segments[m, 0], segments[m, 1], segments[m, 2], segments[m, 3] = ax, ay, bx, by
            kind[m], number[m] = SHADOW_EDGE, frontier
            open_side[m, 0], open_side[m, 1] = reach[k] > reach[j], reach[j] > reach[k]
            m += 1
            frontier += 1
    return Frontiers(segments[:m], kind[:m], number[:m], open_side[:m])
