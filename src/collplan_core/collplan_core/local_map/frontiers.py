"""Frontiers B_i of the free space, where it borders on what is unseen but may be free. Paper: II-A.

Shadow edges, from the near end of an occluding surface to whatever lies behind it, and visible runs of the map border.
Points relative to the centre of the star.
"""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import BORDER, UNSEEN_SURFACE

SHADOW_EDGE, BORDER_RUN = 0, 1
ALONG = 0.1  # sine of the angle within which a step counts as along a face


@njit
def _goes_on(ends: np.ndarray, surface: np.ndarray, normals: np.ndarray, straight: np.ndarray, k: int, j: int) -> bool:
    """Whether the straight face at k goes on to j: a wall almost along the beam, seen on or cut by the map border."""
    if not straight[k] or not (surface[j] == surface[k] or surface[j] == BORDER):
        return False
    dx, dy = ends[j, 0] - ends[k, 0], ends[j, 1] - ends[k, 1]
    off = dx * normals[k, 0] + dy * normals[k, 1]
    if surface[j] == BORDER:  # the map ends before direction j meets the face's line, or the face itself has ended
        return off >= -0.005 * math.hypot(dx, dy) - 1e-4
    return abs(off) <= ALONG * math.hypot(dx, dy) + 1e-4


@njit
def _bends_away(ends: np.ndarray, surface: np.ndarray, normals: np.ndarray, near: int, far: int) -> bool:
    """Whether a step along one surface is a chord of its convex side, as on a corner seen almost along the beam."""
    if surface[near] != surface[far]:
        return False
    dx, dy = ends[far, 0] - ends[near, 0], ends[far, 1] - ends[near, 1]
    falls = dx * normals[near, 0] + dy * normals[near, 1]
    rises = dx * normals[far, 0] + dy * normals[far, 1]
    return falls <= 1e-6 and rises >= -1e-6


@njit
def _explained(reach: np.ndarray, ends: np.ndarray, surface: np.ndarray, normals: np.ndarray, straight: np.ndarray,
               k: int, j: int) -> bool:  # fmt: skip
    """Whether a steep step between directions k and j is one surface all the same."""
    nearer, farther = (k, j) if reach[k] < reach[j] else (j, k)
    if _bends_away(ends, surface, normals, nearer, farther):
        return True
    return _goes_on(ends, surface, normals, straight, k, j) or _goes_on(ends, surface, normals, straight, j, k)


@njit
def find_jumps(reach: np.ndarray, ends: np.ndarray, surface: np.ndarray, normals: np.ndarray, straight: np.ndarray,
               grazing: float) -> np.ndarray:  # fmt: skip
    """(n,) whether the border of F jumps between directions k and k + 1 by more than one surface can explain."""
    n = len(reach)
    step = 2.0 * math.pi / n
    steepest = math.sin(step) / math.sin(max(grazing, 1.5 * step) - step)
    jumps = np.zeros(n, np.bool_)
    for k in range(n):
        j = (k + 1) % n
        if surface[k] == UNSEEN_SURFACE or surface[j] == UNSEEN_SURFACE or (surface[k] == BORDER == surface[j]):
            continue
        across = math.hypot(ends[j, 0] - ends[k, 0], ends[j, 1] - ends[k, 1])
        if across > min(reach[k], reach[j]) * steepest + 1e-6:
            jumps[k] = not _explained(reach, ends, surface, normals, straight, k, j)
    return jumps


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
    """Whether two points of the box's border lie on one side of it."""
    return abs(ax - bx) < 1e-9 or abs(ay - by) < 1e-9


@njit
def find_frontiers(
    reach: np.ndarray, ends: np.ndarray, surface: np.ndarray, jumps: np.ndarray, box: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Straight frontier segments, counter-clockwise around the centre.

    Returns:
        segments (m, 4), kind (m,) SHADOW_EDGE or BORDER_RUN, number of the frontier B_i each belongs to (m,),
        lit (m, 2) the first direction on the lit side going clockwise and going counter-clockwise, -1 for neither.
    """
    n = len(reach)
    segments = np.empty((2 * n + 8, 4))
    kind = np.empty(2 * n + 8, np.int64)
    number = np.empty(2 * n + 8, np.int64)
    lit = np.empty((2 * n + 8, 2), np.int64)
    m, frontier = 0, 0
    start = 0
    while start < n and surface[start] == BORDER and surface[start - 1] == BORDER:
        start += 1
    start %= n
    open_run = False
    for i in range(n):
        k, j = (start + i) % n, (start + i + 1) % n
        ax, ay = ends[k]
        bx, by = ends[j]
        if surface[k] == BORDER and surface[j] == BORDER:
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
                    lit[m, 0], lit[m, 1] = k, j
                    m += 1
                open_run = True
            continue
        if open_run:
            frontier += 1
            open_run = False
        if jumps[k]:
            segments[m, 0], segments[m, 1], segments[m, 2], segments[m, 3] = ax, ay, bx, by
            kind[m], number[m] = SHADOW_EDGE, frontier
            lit[m, 0] = k if reach[k] > reach[j] else -1
            lit[m, 1] = j if reach[j] > reach[k] else -1
            m += 1
            frontier += 1
    return segments[:m], kind[:m], number[:m], lit[:m]
