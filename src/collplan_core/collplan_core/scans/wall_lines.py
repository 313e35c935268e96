"""The noise of a scan, and its ranges replaced by those of the straight pieces of wall that its beams meet.

The inverse range of a line is a sinusoid of the bearing, so that a line is two coefficients of a linear fit. Runs of
beams are split where two lines fit better than one (split and merge, Nguyen et al. 2005), each by its own noise alone.
"""

import math
from dataclasses import replace

import numpy as np

from collplan_core.jit import njit
from collplan_core.scan import ROUNDED, Scan
from collplan_core.sight_lines import is_full_turn, repeats_first

NEGLIGIBLE, MOST = 0.0003, 0.03
"""Limits of the noise [m]: a scan with less is left unchanged; more is implausible."""
FAR = 3.0
"""Ranges beyond are left as they are [m]: their weight would drown that of near ones, and no boundary is kept there."""
PENALTY = 16.0
"""Squared error, in variances of the noise, by which two lines must fit better than one."""
OUTLIER = 4.5
"""A range farther from its line is on none [standard deviations]."""
GRAZING = 0.1
"""Three hits alone on a line that beams meet at a smaller slope are taken for an edge and what is behind it."""
FARTHEST = 3.0
"""No hit is moved to its line by more [standard deviations]."""
FEWEST = 40
"""Smallest number of triples of neighbouring beams for an estimate."""
QUARTILE = 0.3186
"""A quarter of all draws of a normal distribution are within so many standard deviations."""


@njit
def _bends(ranges: np.ndarray, step: float, closed: bool) -> np.ndarray:
    """Returns how far each three neighbouring hits are from lying on a line, in standard deviations of noise of 1 m."""
    n, twice = len(ranges), 2.0 * math.cos(step)
    bends, count = np.empty(n), 0
    for i in range(n if closed else n - 2):
        a, b, c = ranges[i], ranges[(i + 1) % n], ranges[(i + 2) % n]
        if not (0.0 < a < math.inf and 0.0 < b < math.inf and 0.0 < c < math.inf):
            continue
        # the inverse ranges of a line are a sinusoid of the bearing
        bend = b * b * (1.0 / a + 1.0 / c) - twice * b
        bends[count] = abs(bend) / math.sqrt((b / a) ** 4 + (b / c) ** 4 + twice**2)
        count += 1
    return bends[:count]


def range_noise(scan: Scan) -> float:
    """Standard deviation of a range [m], 0 where too few beams hit anything.

    Three neighbouring hits on one flat surface lie on a line but for noise. Of all such triples the quarter that bends
    least is taken, so that up to three quarters of them may be of corners, gaps and curved surfaces.
    """
    step, n = scan.angle_increment, len(scan.ranges)
    n -= repeats_first(n, step)
    bends = _bends(scan.ranges[:n], step, is_full_turn(n, step))
    if len(bends) < FEWEST:
        return 0.0
    quarter = len(bends) // 4
    return float(np.partition(bends, quarter)[quarter]) / QUARTILE


@njit
def _is_hit(r: float) -> bool:
    return 0.0 < r <= FAR


@njit
def _sums(ranges: np.ndarray, beams: np.ndarray, noise: float) -> np.ndarray:
    """(n + 1, 7) over the hits before each beam: their number, and the moments of the fit of a line."""
    sums = np.zeros((len(ranges) + 1, 7))
    for i in range(len(ranges)):
        sums[i + 1] = sums[i]
        r = ranges[i]
        if not _is_hit(r):
            continue
        w, c, s, u = r**4 / noise**2, beams[i, 0], beams[i, 1], 1.0 / r
        sums[i + 1, 0] += 1.0
        sums[i + 1, 1] += w * c * c
        sums[i + 1, 2] += w * c * s
        sums[i + 1, 3] += w * s * s
        sums[i + 1, 4] += w * c * u
        sums[i + 1, 5] += w * s * u
        sums[i + 1, 6] += w * u * u
    return sums


@njit
def _line(sums: np.ndarray, a: int, b: int) -> tuple[float, float, float]:
    """The line through the hits of beams a to b - 1, and its squared error in variances of the noise."""
    # A line x, y has the inverse range x c + y s in the direction (c, s); 0, 0 where fewer than three hits are given.
    cc, cs, ss = sums[b, 1] - sums[a, 1], sums[b, 2] - sums[a, 2], sums[b, 3] - sums[a, 3]
    cu, su = sums[b, 4] - sums[a, 4], sums[b, 5] - sums[a, 5]
    det = cc * ss - cs * cs
    if sums[b, 0] - sums[a, 0] < 3.0 or det <= 0.0:
        return 0.0, 0.0, 0.0
    x, y = (ss * cu - cs * su) / det, (cc * su - cs * cu) / det
    return x, y, max(0.0, sums[b, 6] - sums[a, 6] - x * cu - y * su)


@njit
def _best_split(sums: np.ndarray, a: int, b: int) -> tuple[int, float]:
    """Returns where beams a to b - 1 split into two lines best, and the squared error of both."""
    at, least = a, math.inf
    for m in range(a + 1, b):
        both = _line(sums, a, m)[2] + _line(sums, m, b)[2]
        if both < least:
            at, least = m, both
    return at, least


@njit
def _farthest(ranges: np.ndarray, beams: np.ndarray, x: float, y: float, a: int, b: int) -> tuple[int, float]:
    """The hit of beams a to b - 1 that is farthest from a line, and how far along its beam [m]."""
    at, most = a, 0.0
    for i in range(a, b):
        if _is_hit(ranges[i]):
            off = abs(ranges[i] ** 2 * (x * beams[i, 0] + y * beams[i, 1]) - ranges[i])
            if off > most:
                at, most = i, off
    return at, most


@njit
def _split(ranges: np.ndarray, beams: np.ndarray, sums: np.ndarray, noise: float) -> np.ndarray:
    """(m,) the beams at which another line begins, or hits begin or end."""
    n = len(ranges)
    starts = np.zeros(n + 1, np.bool_)
    stack = [(0, n)]
    begin = 0
    for i in range(n):  # a lost beam, NaN, ends nothing
        if ranges[i] <= 0.0 or ranges[i] > FAR:
            starts[i], starts[i + 1] = True, True
            stack.append((begin, i))
            begin = i + 1
    stack[0] = (begin, n)
    while len(stack) > 0:
        a, b = stack.pop()
        starts[a], starts[b] = True, True
        if sums[b, 0] - sums[a, 0] < 3.0:
            continue
        x, y, alone = _line(sums, a, b)
        at, both = _best_split(sums, a, b)
        if alone - both <= PENALTY:
            at, off = _farthest(ranges, beams, x, y, a, b)
            if off <= OUTLIER * noise:
                continue
            at = max(at, a + 1)
        stack.append((a, at))
        stack.append((at, b))
    return np.flatnonzero(starts)


@njit
def _merge(sums: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """(k,) the starts (m,) less those before which one line fits as well; each of them where two lines part best."""
    kept, count = np.empty(len(starts), np.int64), 0
    for start in starts:
        while count >= 2:
            a, b = kept[count - 2], kept[count - 1]
            nothing = sums[b, 0] == sums[a, 0] or sums[start, 0] == sums[b, 0]
            apart = _line(sums, a, b)[2] + _line(sums, b, start)[2]
            if nothing or _line(sums, a, start)[2] - apart > PENALTY:
                break
            count -= 1
        kept[count] = start
        count += 1
    for k in range(1, count - 1):
        a, b, c = kept[k - 1], kept[k], kept[k + 1]
        if sums[b, 0] > sums[a, 0] and sums[c, 0] > sums[b, 0]:
            kept[k] = _best_split(sums, a, c)[0]
    return kept[:count]


@njit
def _unbiased(ranges: np.ndarray, beams: np.ndarray, a: int, b: int, x: float, y: float) -> tuple[float, float]:
    """The line of beams a to b - 1 after one step of Gauss and Newton on the ranges themselves."""
    # Inverse ranges are not symmetric about the true one: at 0.1 m with 10 mm of noise that is 4 mm.
    cc, cs, ss, ce, se = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(a, b):
        inverse = x * beams[i, 0] + y * beams[i, 1]
        if not (_is_hit(ranges[i]) and inverse > 0.5 / FAR):
            continue
        r = 1.0 / inverse
        c, s, off = r * r * beams[i, 0], r * r * beams[i, 1], r - ranges[i]
        cc, cs, ss = cc + c * c, cs + c * s, ss + s * s
        ce, se = ce + c * off, se + s * off
    det = cc * ss - cs * cs
    return (x, y) if det <= 0.0 else (x + (ss * ce - cs * se) / det, y + (cc * se - cs * ce) / det)


@njit
def _beside(ranges: np.ndarray, i: int, onward: int, around: bool) -> int:
    """The beam beside beam i, the next one where that was lost; -1 where there is none."""
    n = len(ranges)
    for k in (i + onward, i + 2 * onward):
        if not (around or 0 <= k < n):
            return -1
        if not math.isnan(ranges[k % n]):
            return k % n
    return -1


@njit
def _settled(
    ranges: np.ndarray,
    fitted: np.ndarray,
    sums: np.ndarray,
    starts: np.ndarray,
    noise: float,
    step: float,
    around: bool,
) -> np.ndarray:
    """(n,) fitted ranges, with a hit on no line, alone between a near and a far surface, moved to the near one."""
    # Such a beam straddles an edge, and its range is a mean of both: nothing is at its hit. It does meet the near one.
    # With one hit of each surface it may lie on a line, which then runs nearly along the beams.
    settled = fitted.copy()
    for k in range(len(starts) - 1):
        a, b = starts[k], starts[k + 1]
        hits = sums[b, 0] - sums[a, 0]
        if hits > 3.0:
            continue
        for i in range(a, b):
            before, after = _beside(ranges, i, -1, around), _beside(ranges, i, 1, around)
            if before < 0 or after < 0:
                continue
            near, far = min(fitted[before], fitted[after]), max(fitted[before], fitted[after])
            apart = OUTLIER * noise if hits < 3.0 else max(OUTLIER * noise, fitted[i] * step / GRAZING)
            if 0.0 < near < fitted[i] - apart and fitted[i] + apart < far < math.inf:
                settled[i] = near
    return settled


@njit
def _on_lines(ranges: np.ndarray, step: float, noise: float, low: float, high: float, around: bool) -> np.ndarray:
    """(n,) ranges with every hit moved along its beam to the line that it lies on, within `low` and `high` [m]."""
    # A single lost beam, NaN, whose two neighbours lie on one line ends on it too.
    n = len(ranges)
    beams = np.empty((n, 2))
    for i in range(n):
        beams[i, 0], beams[i, 1] = math.cos(i * step), math.sin(i * step)
    sums = _sums(ranges, beams, noise)
    starts = _merge(sums, _split(ranges, beams, sums, noise))
    fitted = ranges.copy()
    for k in range(len(starts) - 1):
        a, b = starts[k], starts[k + 1]
        if sums[b, 0] - sums[a, 0] < 3.0:
            continue
        x, y, _ = _line(sums, a, b)
        x, y = _unbiased(ranges, beams, a, b, x, y)
        for i in range(a, b):
            inverse = x * beams[i, 0] + y * beams[i, 1]
            if inverse <= 0.0:
                continue
            if _is_hit(ranges[i]):
                least, most = max(low, ranges[i] - FARTHEST * noise), min(high, ranges[i] + FARTHEST * noise)
                fitted[i] = min(max(1.0 / inverse, least), most)
            elif math.isnan(ranges[i]) and a < i < b - 1 and _is_hit(ranges[i - 1]) and _is_hit(ranges[i + 1]):
                fitted[i] = min(max(1.0 / inverse, low), high)
    return _settled(ranges, fitted, sums, starts, noise, step, around)


def on_wall_lines(scan: Scan, noise: float) -> Scan:
    """The scan with its hits moved along their beams to the straight walls that they show, by no more than noise moves.

    `noise` is the standard deviation of a range [m].

    A single lost beam between two hits on one wall is given that wall's range, one that straddles an edge the range of
    what is near. The same scan where there is no noise; other beams that were lost, that hit nothing or what is farther
    than FAR stay, and a last beam that repeats the first one.
    """
    noise = min(noise, MOST)
    if noise < NEGLIGIBLE:
        return scan
    step, n = scan.angle_increment, len(scan.ranges)
    # a beam in the direction of another would turn all those behind it by a step
    n -= repeats_first(n, step)
    ranges, again = scan.ranges[:n], scan.ranges[n:]
    # a full turn begins at what is farthest, a corner or nothing at all: not in the middle of a wall
    around = is_full_turn(n, step)
    first = int(np.argmax(np.nan_to_num(ranges))) if around else 0
    farthest = scan.range_max * (1.0 - 2.0 * ROUNDED)  # range_max itself is no hit
    fitted = _on_lines(np.roll(ranges, -first), step, noise, scan.range_min, farthest, around)
    return replace(scan, ranges=np.concatenate([np.roll(fitted, first), again]))


def warm_up(scan: Scan) -> None:
    """Compiles the fits by a scan with noise, so that the first noisy one is not late."""
    noisy = scan.ranges + 0.01 * np.random.default_rng(0).standard_normal(len(scan.ranges))
    scan = replace(scan, ranges=np.maximum(noisy, 0.0))
    on_wall_lines(scan, range_noise(scan))
