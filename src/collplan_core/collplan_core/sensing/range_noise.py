"""Estimate of the range noise of a scan, from the scan itself."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.scan import Scan
from collplan_core.sight_lines import is_full_turn, repeats_first

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
