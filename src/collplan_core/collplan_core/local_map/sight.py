"""theta_sight: how wide the opening is that a candidate looks into. Paper: II-B2, Fig. 2."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import sector


@njit
def _n_open(reach: np.ndarray, start: int, onward: int, sight_distance: float) -> int:
    """Number of neighbouring directions, from start on, that are free as far as the sight distance."""
    n = len(reach)
    count = 0
    while count < n and reach[(start + onward * count) % n] >= sight_distance:
        count += 1
    return count


@njit
def sight_angle(
    reach: np.ndarray, x: float, y: float, clockwise: bool, counter_clockwise: bool, sight_distance: float
) -> float:
    """theta_sight: contiguous angle from the bearing of (x, y) to the open sides of its frontier [rad]. Paper: Fig. 2.

    Args:
        reach: (n,) free distance in direction 2 pi k / n from the centre of F [m].
        x, y: the candidate relative to the centre of F [m].
        sight_distance: distance over which a direction must be free to count [m].
    """
    n = len(reach)
    step = 2.0 * math.pi / n
    k = sector(x, y, n)
    part = (math.atan2(y, x) % (2.0 * math.pi)) / step - k
    total = 0.0
    if counter_clockwise:
        n_open = _n_open(reach, (k + 1) % n, 1, sight_distance)
        total += (n_open - part) * step if n_open > 0 else 0.0
    if clockwise:
        n_open = _n_open(reach, k, -1, sight_distance)
        total += (n_open - 1 + part) * step if n_open > 0 else 0.0
    return min(max(total, 0.0), 2.0 * math.pi)
