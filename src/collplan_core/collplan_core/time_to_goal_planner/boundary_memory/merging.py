"""Pieces of the newest scan merged with the remembered ones."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import OBSERVED, PENDING
from collplan_core.time_to_goal_planner.boundary_memory.contradiction import has_stood, is_edge_on, is_seen_free_behind
from collplan_core.time_to_goal_planner.boundary_memory.working import Cuts, Nodes, Pool, Sight, middle

SAME = 0.002
"""Pieces within this of one line show the same boundary [m]."""
BEHIND = 0.03
"""Older pieces so little behind a new one are the same boundary from a pose that was off [m]."""
FACING = 0.5
"""Cosine of the angle between two pieces' normals from which on they may be of the same boundary."""
GROWTH = 0.003
"""A piece is added where so much of it is new [m]."""
SMALLEST_BUCKET = 0.1
"""Side of the squares in which pieces are looked up [m]; five spacings where that is more."""
AROUND = 0.5
"""Pieces are looked up in the scan's square and so far around it, as beams may begin beside its middle [m]."""
MOST = 64
"""Pieces compared with a new one at most; an ordinary boundary has under ten."""


class Buckets(NamedTuple):
    """Pieces by place: n x n squares of a size from (ox, oy) on, each the head of a chain of piece numbers."""

    head: np.ndarray
    following: np.ndarray
    ox: float
    oy: float
    size: float
    n: int


@njit
def _bucket(buckets: Buckets, piece: np.ndarray) -> tuple[int, int]:
    x, y = middle(piece)
    i, j = int(math.floor((x - buckets.ox) / buckets.size)), int(math.floor((y - buckets.oy) / buckets.size))
    return min(buckets.n - 1, max(0, i)), min(buckets.n - 1, max(0, j))


@njit
def _put(buckets: Buckets, piece: np.ndarray, k: int) -> None:
    i, j = _bucket(buckets, piece)
    buckets.following[k], buckets.head[i, j] = buckets.head[i, j], k


@njit
def _filled(pool: Pool, count: int, sight: Sight, spacing: float) -> Buckets:
    """Buckets of the kept pieces that a new one may be near to."""
    size = max(SMALLEST_BUCKET, 5.0 * spacing)
    half = sight.half_side + AROUND
    n = int(math.ceil(2.0 * half / size))
    x, y = sight.x - half, sight.y - half
    buckets = Buckets(np.full((n, n), -1, np.int64), np.empty(len(pool.kept), np.int64), x, y, size, n)
    for k in range(count):
        mx, my = middle(pool.pieces[k])
        if pool.kept[k] and max(abs(mx - sight.x), abs(my - sight.y)) <= half:
            _put(buckets, pool.pieces[k], k)
    return buckets


@njit
def _span(piece: np.ndarray, normal: np.ndarray, other: np.ndarray) -> tuple[float, float, float, float]:
    """Returns where another piece begins and ends along a piece, and how far in front of it its two ends are [m]."""
    ax, ay, bx, by = other[0] - piece[0], other[1] - piece[1], other[2] - piece[0], other[3] - piece[1]
    tx, ty = -normal[1], normal[0]
    if (piece[2] - piece[0]) * tx + (piece[3] - piece[1]) * ty < 0.0:
        tx, ty = -tx, -ty
    a, b = ax * tx + ay * ty, bx * tx + by * ty
    return min(a, b), max(a, b), ax * normal[0] + ay * normal[1], bx * normal[0] + by * normal[1]


@njit
def _beside(
    pool: Pool, buckets: Buckets, piece: np.ndarray, normal: np.ndarray, length: float
) -> tuple[np.ndarray, np.ndarray]:
    """Pieces that face the same way and overlap along: their numbers (k,) and spans (k, 4)."""
    numbers, spans, count = np.empty(MOST, np.int64), np.empty((MOST, 4)), 0
    ci, cj = _bucket(buckets, piece)
    for i in range(max(0, ci - 1), min(buckets.n, ci + 2)):
        for j in range(max(0, cj - 1), min(buckets.n, cj + 2)):
            q = buckets.head[i, j]
            while q >= 0 and count < MOST:
                facing = pool.normals[q, 0] * normal[0] + pool.normals[q, 1] * normal[1]
                if pool.kept[q] and facing >= FACING:
                    begin, end, front, other_front = _span(piece, normal, pool.pieces[q])
                    if end >= 0.0 and begin <= length:
                        numbers[count] = q
                        spans[count, 0], spans[count, 1] = begin, end
                        spans[count, 2], spans[count, 3] = front, other_front
                        count += 1
                q = buckets.following[q]
    return numbers[:count], spans[:count]


@njit
def _is_same(span: np.ndarray) -> bool:
    return max(abs(span[2]), abs(span[3])) <= SAME


@njit
def _shows_all(span: np.ndarray, length: float) -> bool:
    """Returns whether a remembered piece of the same boundary covers nearly all of a new one of this length."""
    return _is_same(span) and max(0.0, span[0]) + max(0.0, length - span[1]) < GROWTH


@njit
def _gives_way(span: np.ndarray, length: float, shown: bool, fresh: bool, margin: float) -> bool:
    """Returns whether a remembered piece yields to a new one around it, or to its own boundary better seen."""
    if _is_same(span):
        return not shown and span[0] >= -GROWTH and span[1] <= length + GROWTH
    along, front = 0.5 * (span[0] + span[1]), 0.5 * (span[2] + span[3])
    return not fresh and 0.0 <= along <= length and -BEHIND <= front <= margin


@njit
def _refresh(pool: Pool, q: int, stamp: float, stands: bool) -> None:
    pool.seen[q], pool.times_contradicted[q], pool.fresh[q] = stamp, 0, True
    pool.kinds[q] = OBSERVED if stands or pool.kinds[q] == OBSERVED else PENDING


@njit
def _add(
    pool: Pool, k: int, cuts: Cuts, m: int, stamp: float, solid_behind: bool, seen_free: bool, stands: bool
) -> None:
    pool.pieces[k], pool.normals[k] = cuts.pieces[m], cuts.normals[m]
    pool.solid_behind[k], pool.seen_free_behind[k] = solid_behind and not seen_free, seen_free
    pool.kept[k] = True
    _refresh(pool, k, stamp, stands)


@njit
def _merge_piece(
    pool: Pool, k: int, buckets: Buckets, cuts: Cuts, m: int, sight: Sight, seen_free: bool, margin: float
) -> int:
    """Refreshes the piece that shows number m of the scan already, else adds that in place of those that give way."""
    piece, solid, shown, stamp = cuts.pieces[m], cuts.inner[m], False, sight.stamp
    stands = has_stood(sight, *middle(piece))
    length = math.sqrt((piece[2] - piece[0]) ** 2 + (piece[3] - piece[1]) ** 2)
    numbers, spans = _beside(pool, buckets, piece, cuts.normals[m], length)
    for i, q in enumerate(numbers):
        if _shows_all(spans[i], length):
            pool.solid_behind[q] = pool.solid_behind[q] or (solid and not seen_free and not pool.seen_free_behind[q])
            _refresh(pool, q, stamp, stands)
            shown = True
    for i, q in enumerate(numbers):
        if _gives_way(spans[i], length, shown, pool.fresh[q], margin):
            pool.kept[q] = False
            solid, seen_free = solid or pool.solid_behind[q], seen_free or pool.seen_free_behind[q]
            stands = stands or pool.kinds[q] == OBSERVED
        elif _is_same(spans[i]):
            _refresh(pool, q, stamp, stands)
    if shown:
        return k
    _add(pool, k, cuts, m, stamp, solid, seen_free, stands)
    _put(buckets, piece, k)
    return k + 1


@njit
def merge_scan(pool: Pool, count: int, cuts: Cuts, sight: Sight, nodes: Nodes, rows: np.ndarray, margin: float) -> int:
    """Merges the pieces of a scan with the `count` remembered ones; returns how many there are now.

    Args:
        rows: distances of inferred solid behind a piece [m].
        margin: nearer in front of a new piece older ones are the same boundary from a pose that was off [m].
    """
    buckets = _filled(pool, count, sight, nodes.grid.spacing)
    for m in range(len(cuts.pieces)):
        if is_edge_on(cuts.pieces[m], cuts.normals[m], sight):
            continue
        seen_free = cuts.inner[m] and is_seen_free_behind(cuts.pieces[m], cuts.normals[m], rows, sight, nodes)
        count = _merge_piece(pool, count, buckets, cuts, m, sight, seen_free, margin)
    return count
