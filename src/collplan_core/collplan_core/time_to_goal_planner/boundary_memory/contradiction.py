"""Contradiction of the memory by the newest scan: a place that the scan sees through is free."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.sight_lines import place_towards
from collplan_core.time_to_goal_planner.boundary_memory.working import Pool, Sight, middle

EDGE_ON = 0.1
"""A piece that a beam meets at a smaller sine is neither confirmed nor contradicted: all that lies in that direction is
near its line, whatever it is."""
SCANS = 2
"""Number of scans in a row that must see through a piece: a single beam may slip past a thin end."""


@njit
def seen_beyond(sight: Sight, x: float, y: float) -> float:
    """Returns how much farther than a point both beams beside it see [m]; below 0 where one does not or is missing."""
    n = len(sight.ranges)
    dx, dy = x - sight.x, y - sight.y
    if n < 2 or max(abs(dx), abs(dy)) > sight.half_side:
        return -math.inf
    if len(sight.beams) == 0:
        before = int(math.floor(((math.atan2(dy, dx) - sight.first) % (2.0 * math.pi)) / sight.step))
    else:
        before = int(math.floor(place_towards(x, y, sight.beams, sight.first, sight.step, n // 2)))
        nearest = min(before, n - 1)
        dx, dy = x - sight.beams[nearest, 0], y - sight.beams[nearest, 1]
    after = before + 1
    if after >= n:
        if abs(n * sight.step - 2.0 * math.pi) > 0.5 * sight.step:
            return -math.inf
        before, after = before % n, after % n
    return min(sight.ranges[before], sight.ranges[after]) - math.sqrt(dx * dx + dy * dy)


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
