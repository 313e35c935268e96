"""Contradiction of the memory by the newest scan: a place that it sees through is free."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.sight_lines import place_towards
from collplan_core.time_to_goal_planner.boundary_memory.field import window
from collplan_core.time_to_goal_planner.boundary_memory.working import Nodes, Pool, Sight, middle

EDGE_ON = 0.1
"""A piece that a beam meets at a smaller sine is neither confirmed nor contradicted: all that lies in that direction is
near its line, whatever it is."""
SCANS = 2
"""Number of scans in a row that must see through a piece: a single beam may slip past a thin end."""


@njit
def _beams_beside(sight: Sight, x: float, y: float) -> tuple[int, int, float]:
    """The beams before and after a point, and its distance from their origin [m]; -1, -1 where one is missing."""
    n = len(sight.ranges)
    dx, dy = x - sight.x, y - sight.y
    if n < 2 or max(abs(dx), abs(dy)) > sight.half_side:
        return -1, -1, 0.0
    if len(sight.beams) == 0:
        before = int(math.floor(((math.atan2(dy, dx) - sight.first) % (2.0 * math.pi)) / sight.step))
    else:
        before = int(math.floor(place_towards(x, y, sight.beams, sight.first, sight.step, n // 2)))
        nearest = min(before, n - 1)
        dx, dy = x - sight.beams[nearest, 0], y - sight.beams[nearest, 1]
    after = before + 1
    if after >= n:
        if abs(n * sight.step - 2.0 * math.pi) > 0.5 * sight.step:
            return -1, -1, 0.0
        before, after = before % n, after % n
    return before, after, math.sqrt(dx * dx + dy * dy)


@njit
def seen_beyond(sight: Sight, x: float, y: float) -> float:
    """Returns how much farther than a point both beams beside it see [m]; below 0 where one does not or is missing."""
    before, after, away = _beams_beside(sight, x, y)
    return min(sight.ranges[before], sight.ranges[after]) - away if before >= 0 else -math.inf


@njit
def has_stood(sight: Sight, x: float, y: float) -> bool:
    """Returns whether what a beam beside a point met has stood in place."""
    before, after, _ = _beams_beside(sight, x, y)
    return before >= 0 and (sight.stands[before] or sight.stands[after])


@njit
def _ahead(piece: np.ndarray, normal: np.ndarray, sight: Sight) -> tuple[float, float]:
    """Returns the distances of a piece's middle and of its line from the origin of the beams [m]."""
    x, y = middle(piece)
    dx, dy = x - sight.x, y - sight.y
    return math.sqrt(dx * dx + dy * dy), abs(dx * normal[0] + dy * normal[1])


@njit
def is_edge_on(piece: np.ndarray, normal: np.ndarray, sight: Sight) -> bool:
    """Returns whether the scan sees a piece too flatly to tell it from what is beyond its end."""
    far, square = _ahead(piece, normal, sight)
    return square <= EDGE_ON * far


@njit
def _sees_through(piece: np.ndarray, normal: np.ndarray, sight: Sight, margin: float) -> bool:
    """Returns whether the scan sees farther than a piece by `margin`, measured perpendicular to it."""
    x, y = middle(piece)
    far, square = _ahead(piece, normal, sight)
    return square > EDGE_ON * far and seen_beyond(sight, x, y) * square > margin * far


@njit
def count_contradictions(pool: Pool, count: int, sight: Sight, margin: float) -> None:
    """Counts the scans running that saw through each piece by `margin`, and drops it after SCANS of them."""
    for k in range(count):
        if _sees_through(pool.pieces[k], pool.normals[k], sight, margin):
            pool.times_contradicted[k] += 1
            pool.kept[k] = pool.times_contradicted[k] < SCANS
        else:
            pool.times_contradicted[k] = 0


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
