"""Pieces of the newest scan taken up among the remembered ones."""

import math

import numpy as np

from collplan_core.jit import njit

SAME = 0.002
"""Pieces this near to each other's line are of one boundary [m]."""
DRIFT = 0.03
"""A nearly parallel older piece this near is the same boundary from a pose that was off [m]."""
PARALLEL = math.cos(math.radians(20.0))
GROWTH = 0.003
"""A piece is taken up if so much of it is new [m]."""
MOST = 64
"""Remembered pieces looked at for one new one."""


@njit
def bucket_of(x: float, y: float, ox: float, oy: float, size: float, n: int) -> int:
    """Number of the bucket a point belongs to; points outside belong to the nearest."""
    i = min(n - 1, max(0, int(math.floor((x - ox) / size))))
    j = min(n - 1, max(0, int(math.floor((y - oy) / size))))
    return i * n + j


@njit
def _along_and_off(piece: np.ndarray, other: np.ndarray) -> tuple[float, float, float, float, float]:
    """Of another piece its ends along a piece [m], its distances from the piece's line there, the piece's length."""
    dx, dy = piece[2] - piece[0], piece[3] - piece[1]
    length = math.hypot(dx, dy)
    if length < 1e-9:
        a = math.hypot(other[0] - piece[0], other[1] - piece[1])
        b = math.hypot(other[2] - piece[0], other[3] - piece[1])
        qx, qy = other[2] - other[0], other[3] - other[1]
        span = math.hypot(qx, qy)
        if span < 1e-9:
            return 0.0, 0.0, a, b, 0.0
        ux, uy = qx / span, qy / span
        s = (other[0] - piece[0]) * ux + (other[1] - piece[1]) * uy
        off = ux * (other[1] - piece[1]) - uy * (other[0] - piece[0])
        return s, s + span, off, off, 0.0
    ux, uy = dx / length, dy / length
    ax, ay, bx, by = other[0] - piece[0], other[1] - piece[1], other[2] - piece[0], other[3] - piece[1]
    a, b = ax * ux + ay * uy, bx * ux + by * uy
    off_a, off_b = ux * ay - uy * ax, ux * by - uy * bx
    return (a, b, off_a, off_b, length) if a <= b else (b, a, off_b, off_a, length)


@njit
def _uncovered(spans: np.ndarray, count: int, length: float) -> float:
    """How much of 0 to `length` the spans leave at its ends together [m]."""
    low, high = 0.0, length
    for _ in range(count):
        for i in range(count):
            if spans[i, 0] <= low + 1e-9 and spans[i, 1] > low:
                low = spans[i, 1]
            if spans[i, 1] >= high - 1e-9 and spans[i, 0] < high:
                high = spans[i, 0]
    return max(0.0, high - low) if count > 0 else max(length, GROWTH)


@njit
def take_up(piece: np.ndarray, normal: np.ndarray, inner: bool, refutable: bool, stamp: float, k: int,
            pieces: np.ndarray, normals: np.ndarray, backed: np.ndarray, refuted: np.ndarray, seen: np.ndarray,
            doubted: np.ndarray, kept: np.ndarray, fresh: np.ndarray, raised: np.ndarray, head: np.ndarray,
            following: np.ndarray, ox: float, oy: float, size: float, n: int) -> int:  # fmt: skip
    """Take up one new piece: refresh those that show it already, else add it in place of what it replaces.

    Args:
        inner: whether solid may be inferred behind it; refutable: whether the scan sees that this is free.
        k: how many pieces there are. The others are theirs, longer than k: kept (not let go of), fresh (shown by this
            scan), raised (backed anew).
        head, following, ox, oy, size, n: n x n buckets of pieces as linked lists.

    Returns:
        How many pieces there are now.
    """
    spans = np.empty((MOST, 2))
    same, count = np.empty(MOST, np.int64), 0
    old, gone = np.empty(MOST, np.int64), 0
    mx, my = 0.5 * (piece[0] + piece[2]), 0.5 * (piece[1] + piece[3])
    ci, cj = bucket_of(mx, my, ox, oy, size, n) // n, bucket_of(mx, my, ox, oy, size, n) % n
    for i in range(max(0, ci - 1), min(n, ci + 2)):
        for j in range(max(0, cj - 1), min(n, cj + 2)):
            q = head[i * n + j]
            while q >= 0:
                if kept[q] and normals[q, 0] * normal[0] + normals[q, 1] * normal[1] >= PARALLEL:
                    a, b, off_a, off_b, length = _along_and_off(piece, pieces[q])
                    if b >= 0.0 and a <= length:
                        if max(abs(off_a), abs(off_b)) <= SAME:
                            if count < MOST:
                                spans[count, 0], spans[count, 1] = a, b
                                same[count] = q
                                count += 1
                        elif not fresh[q] and 0.0 <= 0.5 * (a + b) <= length and abs(off_a + off_b) <= 2.0 * DRIFT:
                            if gone < MOST:
                                old[gone] = q
                                gone += 1
                q = following[q]
    length = math.hypot(piece[2] - piece[0], piece[3] - piece[1])
    covered = _uncovered(spans, count, length) < GROWTH
    was_refuted, was_backed = refutable, False
    for i in range(gone):
        q = old[i]
        kept[q] = False
        was_refuted, was_backed = was_refuted or refuted[q], was_backed or backed[q]
    for i in range(count):
        q = same[i]
        seen[q], doubted[q], fresh[q] = stamp, 0, True
        middle = 0.5 * (spans[i, 0] + spans[i, 1])
        if covered:
            if inner and not backed[q] and not refuted[q] and not refutable and 0.0 <= middle <= length:
                backed[q], raised[q] = True, True
        elif spans[i, 0] >= -GROWTH and spans[i, 1] <= length + GROWTH:
            kept[q] = False
            was_refuted, was_backed = was_refuted or refuted[q], was_backed or backed[q]
    if covered:
        return k
    pieces[k], normals[k] = piece, normal
    refuted[k] = was_refuted
    backed[k] = (inner or was_backed) and not was_refuted
    seen[k], doubted[k], kept[k], fresh[k] = stamp, 0, True, True
    bucket = ci * n + cj
    following[k], head[bucket] = head[bucket], k
    return k + 1
