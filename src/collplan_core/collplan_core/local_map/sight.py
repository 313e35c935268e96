"""theta_sight: how wide the opening is that a candidate looks into. Paper: II-B2, Fig. 2."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import sector


@njit
def _open_angle(reach: np.ndarray, start: int, onward: int, far: float) -> int:
    """Number of neighbouring directions from start on that are free beyond far."""
    n = len(reach)
    count = 0
    while count < n and reach[(start + onward * count) % n] >= far:
        count += 1
    return count


@njit
def sight_angle(reach: np.ndarray, x: float, y: float, clockwise: bool, counter_clockwise: bool, far: float) -> float:
    """Contiguous angle from the bearing of (x, y) to the lit side of its frontier that is free beyond far [rad]."""
    n = len(reach)
    step = 2.0 * math.pi / n
    k = sector(x, y, n)
    part = (math.atan2(y, x) % (2.0 * math.pi)) / step - k
    total = 0.0
    if counter_clockwise:
        free = _open_angle(reach, (k + 1) % n, 1, far)
        total += (free - part) * step if free > 0 else 0.0
    if clockwise:
        free = _open_angle(reach, k, -1, far)
        total += (free - 1 + part) * step if free > 0 else 0.0
    return min(max(total, 0.0), 2.0 * math.pi)
