"""What the newest scan says against the memory: a place that it sees through is free."""

import math

from collplan_core.jit import njit
from collplan_core.remembered.working import Pool, Sight, middle

EDGE_ON = 0.1
"""A piece is not judged where a beam meets it at a smaller sine: which side it passes on is the noise of the pose."""
SCANS = 2
"""So many scans running must see through a piece: a single beam may slip past a thin end."""


@njit
def seen_beyond(sight: Sight, x: float, y: float) -> float:
    """By how much both beams beside a point see farther than it [m]; below 0 where one does not, or there is none."""
    n = len(sight.ranges)
    dx, dy = x - sight.x, y - sight.y
    if n < 2 or max(abs(dx), abs(dy)) > sight.half_side:
        return -math.inf
    before = int(math.floor(((math.atan2(dy, dx) - sight.first) % (2.0 * math.pi)) / sight.step))
    after = before + 1
    if after >= n:
        if abs(n * sight.step - 2.0 * math.pi) > 0.5 * sight.step:
            return -math.inf
        before, after = before % n, after % n
    return min(sight.ranges[before], sight.ranges[after]) - math.sqrt(dx * dx + dy * dy)


@njit
def _sees_through(pool: Pool, k: int, sight: Sight, margin: float) -> bool:
    """Whether the scan sees farther than a piece by `margin`, measured square to it."""
    x, y = middle(pool.pieces[k])
    dx, dy = x - sight.x, y - sight.y
    far = math.sqrt(dx * dx + dy * dy)
    square = abs(dx * pool.normals[k, 0] + dy * pool.normals[k, 1])
    return square > EDGE_ON * far and seen_beyond(sight, x, y) * square > margin * far


@njit
def doubt(pool: Pool, count: int, sight: Sight, margin: float) -> None:
    """Let go of the pieces that SCANS scans running have seen through by `margin`."""
    for k in range(count):
        if _sees_through(pool, k, sight, margin):
            pool.doubted[k] += 1
            pool.kept[k] = pool.doubted[k] < SCANS
        else:
            pool.doubted[k] = 0
