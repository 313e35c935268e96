"""Point where a path leaves F through an observed boundary. Paper: III-B, p_c."""

import math
from dataclasses import dataclass

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import boundary_at, inside, sector
from collplan_core.local_map.record import LocalMap
from collplan_core.plane import nearest_on_segment


@dataclass(frozen=True, eq=False)
class ContactPoint:
    """Engaging point p_c, where a reference first leaves F through an observed boundary."""

    index: int  # first sample of the reference beyond the boundary
    share: float  # place between the samples index - 1 and index, in [0, 1]
    point: np.ndarray  # (2,) position of the disc's centre there [m]
    direction: np.ndarray  # (2,) unit direction of the reference there
    normal: np.ndarray  # (2,) unit normal out of the obstacle
    surface: int  # number of the observed surface in its map


@njit
def _first_exit(
    border: np.ndarray, surface: np.ndarray, shadow: np.ndarray, path: np.ndarray
) -> tuple[int, float, int]:
    """Sample at which a path from F's centre leaves F by a boundary (-1: never), share of its step, direction met."""
    for i in range(1, len(path)):
        if inside(border, path[i, 0], path[i, 1]):
            continue
        low, high = 0.0, 1.0
        for _ in range(20):
            middle = 0.5 * (low + high)
            x = path[i - 1, 0] + middle * (path[i, 0] - path[i - 1, 0])
            y = path[i - 1, 1] + middle * (path[i, 1] - path[i - 1, 1])
            if inside(border, x, y):
                low = middle
            else:
                high = middle
        x = path[i - 1, 0] + high * (path[i, 0] - path[i - 1, 0])
        y = path[i - 1, 1] + high * (path[i, 1] - path[i - 1, 1])
        k = boundary_at(surface, shadow, sector(x, y, len(border)))
        return (i, high, k) if k >= 0 else (-1, 0.0, -1)
    return -1, 0.0, -1


def find_contact(path: np.ndarray, local_map: LocalMap) -> ContactPoint | None:
    """p_c of a reference (n, 2), or None where it stays in F or leaves it through a frontier."""
    index, share, k = _first_exit(local_map.border, local_map.surface, local_map.shadow, path - local_map.position)
    if index < 0:
        return None
    step = path[index] - path[index - 1]
    return ContactPoint(
        index=index,
        share=share,
        point=path[index - 1] + share * step,
        direction=step / max(float(np.hypot(*step)), 1e-12),
        normal=local_map.normals[k],
        surface=int(local_map.surface[k]),
    )


@njit
def nearest_on_surface(border: np.ndarray, surface: np.ndarray, number: int, x: float, y: float) -> tuple[float, float]:
    """Nearest point to (x, y) on the edges of the border (n, 2) of F that are on the numbered surface [m]."""
    n = len(border)
    least, nearest_x, nearest_y = math.inf, x, y
    for k in range(n):
        j = (k + 1) % n
        if surface[k] != number or surface[j] != number:
            continue
        px, py = nearest_on_segment(border[k, 0], border[k, 1], border[j, 0], border[j, 1], x, y)
        distance2 = (x - px) ** 2 + (y - py) ** 2
        if distance2 < least:
            least, nearest_x, nearest_y = distance2, px, py
    return nearest_x, nearest_y


SAME_POINT = 1e-9
"""Points nearer to each other than this are one [m]."""
GRAZE = 0.05
"""A path that comes back from beyond a boundary by less than this touches it, as one does that reflects there [m]."""
CLIPPED = 0.003
"""A path that was deeper than this beyond a boundary before its end clips it, and does not go round the end [m].

Poses are hardly more accurate than that: mocap.position_noise.
"""


@njit
def _is_end(border: np.ndarray, surface: np.ndarray, number: int, x: float, y: float) -> bool:
    """Returns whether (x, y) is a vertex of the border (n, 2) where the visible part of the numbered surface ends."""
    n = len(border)
    for k in range(n):
        if surface[k] == number and math.hypot(border[k, 0] - x, border[k, 1] - y) < SAME_POINT:
            return surface[(k + 1) % n] != number or surface[k - 1] != number
    return False


@njit
def _passes_through(free: tuple[np.ndarray, np.ndarray, np.ndarray], number: int, path: np.ndarray, first: int) -> bool:
    """True where the path, beyond the numbered surface from sample `first`, ends there or goes deeper than GRAZE."""
    # It is no longer beyond where it is in F again or behind a frontier, or goes round the end of what is seen of the
    # surface. `free` is border, surface and shadow of F.
    border, surface, shadow = free
    depth = 0.0
    for i in range(first, len(path)):
        px, py = path[i, 0], path[i, 1]
        if inside(border, px, py) or boundary_at(surface, shadow, sector(px, py, len(border))) < 0:
            return False
        x, y = nearest_on_surface(border, surface, number, px, py)
        if depth <= CLIPPED and _is_end(border, surface, number, x, y):
            return False
        depth = math.hypot(px - x, py - y)
        if depth > GRAZE:
            return True
    return True


def passes_through(path: np.ndarray, contact: ContactPoint, local_map: LocalMap) -> bool:
    """Returns whether a path (n, 2) goes on beyond the boundary at its contact point, instead of reflecting there."""
    free = local_map.border, local_map.surface, local_map.shadow
    return _passes_through(free, contact.surface, path - local_map.position, contact.index)
