"""Walls cut into short pieces, at the same places in every scan."""

import math

import numpy as np

from collplan_core.jit import njit


@njit
def _clip(ax: float, ay: float, bx: float, by: float, half: float) -> tuple[float, float]:
    """Shares of a segment between which it lies in the square of half side `half` around the origin; 1, 0 if nowhere.

    Liang and Barsky 1984.
    """
    low, high = 0.0, 1.0
    for p, d in ((ax, bx - ax), (ay, by - ay)):
        if d == 0.0:
            if abs(p) > half:
                return 1.0, 0.0
            continue
        enter, leave = (-half - p) / d, (half - p) / d
        if enter > leave:
            enter, leave = leave, enter
        low, high = max(low, enter), min(high, leave)
    return (low, high) if low <= high else (1.0, 0.0)


@njit
def _linked(walls: np.ndarray, owner: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """(w,) the wall that a wall goes on from without a break, -1 where what was seen begins with it."""
    n = len(walls)
    linked = np.full(n, -1, np.int64)
    first = 0
    for i in range(n):
        if i > 0 and owner[i] != owner[i - 1]:
            first = i
        if i > first and shares[i - 1, 1] == 1.0 and shares[i, 0] == 0.0:
            linked[i] = i - 1
        ends = i == n - 1 or owner[i + 1] != owner[i]
        closed = walls[i, 2] == walls[first, 0] and walls[i, 3] == walls[first, 1]
        if ends and closed and i > first and shares[i, 1] == 1.0 and shares[first, 0] == 0.0:
            linked[first] = i
    return linked


@njit
def _seen_beside(linked: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(w,) along the surface, how far it was seen before the begin and beyond the end of each wall [m]."""
    n = len(linked)
    before, after = np.zeros(n), np.zeros(n)
    for _ in range(2):  # the second time for surfaces that close
        for i in range(n):
            j = linked[i]
            if j >= 0:
                before[i] = before[j] + lengths[j]
    for _ in range(2):
        for i in range(n - 1, -1, -1):
            j = linked[i]
            if j >= 0:
                after[j] = after[i] + lengths[i]
    return before, after


@njit
def _cut_one(wall: np.ndarray, low: float, high: float, spacing: float, pieces: np.ndarray, cores: np.ndarray,
             k: int) -> int:  # fmt: skip
    """Cut a wall where its steeper coordinate is a multiple of `spacing`; the count of pieces after it.

    Pieces reach over their neighbours by half a spacing. Where the wall was clipped only whole ones are kept: what is
    missing comes with a later scan.
    """
    dx, dy = wall[2] - wall[0], wall[3] - wall[1]
    length = math.hypot(dx, dy)
    if length < 1e-9:
        pieces[k] = wall
        cores[k] = 0.0
        return k + 1
    begin, rise = (wall[0], dx) if abs(dx) >= abs(dy) else (wall[1], dy)
    over = 0.5 * spacing
    first, last = begin + low * rise, begin + high * rise
    n = int(math.floor(max(first, last) / spacing)) - int(math.floor(min(first, last) / spacing))
    base = math.floor(min(first, last) / spacing)
    for i in range(n + 1):
        a, b = ((base + i) * spacing - begin) / rise, ((base + i + 1) * spacing - begin) / rise
        if a > b:
            a, b = b, a
        a, b = max(a, low), min(b, high)
        if (b - a) * length < 1e-9:
            continue
        s, e = a * length - over, b * length + over
        if (low > 0.0 and s < low * length) or (high < 1.0 and e > high * length):
            continue
        s, e = max(0.0, s) / length, min(length, e) / length
        pieces[k, 0], pieces[k, 1] = wall[0] + s * dx, wall[1] + s * dy
        pieces[k, 2], pieces[k, 3] = wall[0] + e * dx, wall[1] + e * dy
        cores[k, 0], cores[k, 1] = a * length, b * length
        k += 1
    return k


@njit
def cut(walls: np.ndarray, owner: np.ndarray, x: float, y: float, half_side: float, spacing: float,
        inset: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Cut the walls seen from (x, y) in the square of `half_side` around it.

    Returns:
        pieces (m, 4), their unit normals (m, 2) toward (x, y), and (m,) whether they are `inset` from both ends of what
        was seen of their surface.
    """
    n = len(walls)
    shares, lengths = np.empty((n, 2)), np.zeros(n)
    most = 0
    for i in range(n):
        x0, y0, x1, y1 = walls[i]
        shares[i] = _clip(x0 - x, y0 - y, x1 - x, y1 - y, half_side)
        length = math.hypot(x1 - x0, y1 - y0)
        if shares[i, 0] <= shares[i, 1]:
            lengths[i] = (shares[i, 1] - shares[i, 0]) * length
            most += int(lengths[i] / spacing) + 3
    before, after = _seen_beside(_linked(walls, owner, shares), lengths)
    pieces, cores, of = np.empty((most, 4)), np.empty((most, 2)), np.empty(most, np.int64)
    k = 0
    for i in range(n):
        if shares[i, 0] <= shares[i, 1]:
            begin = k
            k = _cut_one(walls[i], shares[i, 0], shares[i, 1], spacing, pieces, cores, k)
            of[begin:k] = i
    normals, inner = np.empty((k, 2)), np.empty(k, np.bool_)
    for j in range(k):
        i = of[j]
        begin = shares[i, 0] * math.hypot(walls[i, 2] - walls[i, 0], walls[i, 3] - walls[i, 1])
        past = cores[j, 0] - begin
        rest = lengths[i] - (cores[j, 1] - begin)
        inner[j] = before[i] + past >= inset - 1e-9 and after[i] + rest >= inset - 1e-9
        normals[j] = normal_toward(pieces[j], walls[i], x, y)
    return pieces[:k], normals, inner


@njit
def normal_toward(piece: np.ndarray, wall: np.ndarray, x: float, y: float) -> tuple[float, float]:
    """Unit normal of a wall toward (x, y); of a point the direction to it."""
    dx, dy = wall[2] - wall[0], wall[3] - wall[1]
    length = math.hypot(dx, dy)
    tx, ty = x - piece[0], y - piece[1]
    if length < 1e-9:
        far = max(math.hypot(tx, ty), 1e-12)
        return tx / far, ty / far
    nx, ny = -dy / length, dx / length
    return (nx, ny) if nx * tx + ny * ty >= 0.0 else (-nx, -ny)
