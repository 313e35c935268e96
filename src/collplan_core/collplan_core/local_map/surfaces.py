"""Surfaces in a scan, and the straight pieces that they consist of. All points are relative to the robot."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit

HIT, OPEN, UNSEEN = 0, 1, 2


class Sweep(NamedTuple):
    """Geometry of a scan's beams, and the limits within which two of them see one surface."""

    first: float  # bearing of the first beam [rad, world frame]
    step: float  # angle from beam to beam [rad], above 0
    closed: bool  # whether the first beam follows the last one
    range_min: float  # nearest range a beam measures [m]
    grazing: float  # smallest angle between beam and surface that joins two hits by their distance alone [rad]
    tolerance: float  # distance of a hit from a straight piece, or from a line, within which it lies on it [m]


@njit
def beam_kinds(ranges: np.ndarray, range_min: float) -> tuple[np.ndarray, np.ndarray]:
    """Kind of each beam and its range: -Inf is a hit at range_min, +Inf is open, NaN is unseen."""
    n = len(ranges)
    kind = np.empty(n, np.int64)
    distance = np.empty(n)
    for i in range(n):
        r = ranges[i]
        if math.isnan(r):
            kind[i], distance[i] = UNSEEN, 0.0
        elif r == math.inf:
            kind[i], distance[i] = OPEN, math.inf
        else:
            kind[i], distance[i] = HIT, max(r, range_min, 1e-4)
    return kind, distance


@njit
def _off_line(px: float, py: float, ax: float, ay: float, bx: float, by: float) -> float:
    """Distance of p from the line through a and b; from a where they coincide."""
    dx, dy = bx - ax, by - ay
    length = math.hypot(dx, dy)
    if length < 1e-12:
        return math.hypot(px - ax, py - ay)
    return abs(dx * (py - ay) - dy * (px - ax)) / length


@njit
def _are_joined(hits: np.ndarray, distance: np.ndarray, before: int, i: int, j: int, after: int, sweep: Sweep) -> bool:
    """True where hits i and j, one beam apart, lie on one surface; before, after: their neighbours, -1 for none."""
    # Either their distance is one that a wall at the grazing angle explains (adaptive breakpoint, Borges and Aldon
    # 2004), or one of them lies on the line through the other and its own neighbour: a wall at a still flatter angle.
    gap = math.hypot(hits[j, 0] - hits[i, 0], hits[j, 1] - hits[i, 1])
    flattest = max(sweep.grazing, 1.5 * sweep.step)
    if gap <= min(distance[i], distance[j]) * math.sin(sweep.step) / math.sin(flattest - sweep.step):
        return True
    for k, a, b in ((before, i, j), (after, j, i)):
        if k < 0 or math.hypot(hits[k, 0] - hits[a, 0], hits[k, 1] - hits[a, 1]) < sweep.tolerance:
            continue
        ahead = (hits[a, 0] - hits[k, 0]) * (hits[b, 0] - hits[a, 0]) + (hits[a, 1] - hits[k, 1]) * (
            hits[b, 1] - hits[a, 1]
        )
        off = _off_line(hits[b, 0], hits[b, 1], hits[k, 0], hits[k, 1], hits[a, 0], hits[a, 1])
        if ahead > 0.0 and off <= sweep.tolerance + 1e-9:
            return True
    return False


@njit
def find_surfaces(kind: np.ndarray, distance: np.ndarray, hits: np.ndarray, sweep: Sweep) -> np.ndarray:
    """(n,) whether beam i and the next one are on one surface; the last entry closes the turn."""
    n = len(kind)
    joined = np.zeros(n, np.bool_)
    for i in range(n if sweep.closed else n - 1):
        j = (i + 1) % n
        if kind[i] != HIT or kind[j] != HIT:
            continue
        before = (i - 1) % n if sweep.closed else i - 1
        after = (j + 1) % n if sweep.closed else j + 1
        before = before if before >= 0 and kind[before] == HIT else -1
        after = after if after < n and kind[after] == HIT else -1
        joined[i] = _are_joined(hits, distance, before, i, j, after, sweep)
    return joined


@njit
def _split(hits: np.ndarray, first: int, last: int, tolerance: float, corner: np.ndarray) -> None:
    """Mark the hits between first and last (indices may exceed n: they wrap) at which the run of hits bends."""
    n = len(hits)
    stack = [(first, last)]
    while len(stack) > 0:
        a, b = stack.pop()
        worst, at = tolerance, -1
        for i in range(a + 1, b):
            off = _off_line(
                hits[i % n, 0], hits[i % n, 1], hits[a % n, 0], hits[a % n, 1], hits[b % n, 0], hits[b % n, 1]
            )
            if off > worst + 1e-9:  # of a wall parallel to the chord its end, not what rounding picks
                worst, at = off, i
        if at >= 0:
            corner[at % n] = True
            stack.append((a, at))
            stack.append((at, b))


@njit
def fit_pieces(
    kind: np.ndarray, hits: np.ndarray, joined: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Straight pieces along every surface (split where it bends by more than the tolerance).

    Returns:
        pieces (m, 4), the surface number of each piece (m,), the surface number of each beam (n,), -1 without a hit,
        and the piece between whose ends each beam's hit lies (n,), -1 at the ends and without a hit.
        A surface of one hit is a piece of length 0.
    """
    n = len(kind)
    surface_of, piece_of = np.full(n, -1, np.int64), np.full(n, -1, np.int64)
    pieces = np.empty((n + 1, 4))
    owner = np.empty(n + 1, np.int64)
    corner = np.zeros(n, np.bool_)
    count, surface = 0, 0
    start = 0
    while start < n and joined[start - 1]:
        start += 1
    if start == n:  # one surface all around, without an end: begin at a corner, wherever the first beam points
        start = int(np.argmax(hits[:, 0] ** 2 + hits[:, 1] ** 2))
    i = start
    while i < start + n:
        if kind[i % n] != HIT:
            i += 1
            continue
        last = i
        while last - i < n and joined[last % n]:
            last += 1
        _split(hits, i, last, tolerance, corner)
        a = i
        for k in range(i, last + 1):
            if k < start + n:
                surface_of[k % n] = surface
            if (k > i and (corner[k % n] or k == last)) or last == i:
                pieces[count, 0], pieces[count, 1] = hits[a % n, 0], hits[a % n, 1]
                pieces[count, 2], pieces[count, 3] = hits[k % n, 0], hits[k % n, 1]
                owner[count] = surface
                for between in range(a + 1, k):
                    piece_of[between % n] = count
                count += 1
                a = k
        surface += 1
        i = last + 1
    return pieces[:count], owner[:count], surface_of, piece_of
