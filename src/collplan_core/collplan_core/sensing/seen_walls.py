"""The straight pieces of wall that a scan shows, beam by beam, in the world frame."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.scan import Scan
from collplan_core.sight_lines import is_full_turn

NEAR = 3.0
"""Walls farther than this are not kept: a pose turned by 0.01 rad moves them by more than they are looked for [m]."""
HALF_LENGTH = 0.05
"""Half the length of wall that a beam's neighbours must show [m]: long against the noise of a range, 0.01 m."""
STRAIGHTNESS = 0.03
"""Largest distance of these neighbours from the line through the outer two: beyond it is a corner or a gap [m]."""
MOST_NEIGHBOURS = 15
"""On either side of a beam."""
FLATTEST = 4.0
"""How much longer than across the beams a piece may be: a wall met at a smaller angle than 14 degrees is not kept."""


@njit
def _pieces(ranges: np.ndarray, beams: np.ndarray, first: float, step: float) -> np.ndarray:
    n = len(ranges)
    closed = is_full_turn(n, step)
    hits = np.empty((n, 2))
    for i in range(n):
        angle = beams[i, 2] + first + i * step
        hits[i, 0] = beams[i, 0] + ranges[i] * math.cos(angle)
        hits[i, 1] = beams[i, 1] + ranges[i] * math.sin(angle)
    pieces = np.full((n, 4), math.nan)
    for i in range(n):
        if not 0.0 < ranges[i] <= NEAR:
            continue
        across = ranges[i] * abs(step)
        m = int(min(max(math.ceil(HALF_LENGTH / across), 1), MOST_NEIGHBOURS))
        if 2 * m >= n or (not closed and (i < m or i + m >= n)):
            continue
        a, b = (i - m) % n, (i + m) % n
        along_x, along_y = hits[b, 0] - hits[a, 0], hits[b, 1] - hits[a, 1]
        length = math.hypot(along_x, along_y)
        # false where one of the two is no number
        if not 0.0 < length <= FLATTEST * 2 * m * across:
            continue
        normal_x, normal_y = -along_y / length, along_x / length
        straight = True
        for k in range(i - m, i + m + 1):
            # below 0 counts from the end by itself
            j = k if k < n else k - n
            off = (hits[j, 0] - hits[a, 0]) * normal_x + (hits[j, 1] - hits[a, 1]) * normal_y
            # a beam lost among others that show a wall leaves it a wall
            if abs(off) > STRAIGHTNESS or math.isinf(ranges[j]):
                straight = False
                break
        if not straight:
            continue
        if (beams[i, 0] - hits[i, 0]) * normal_x + (beams[i, 1] - hits[i, 1]) * normal_y < 0.0:
            normal_x, normal_y = -normal_x, -normal_y
        pieces[i, 0], pieces[i, 1] = hits[i, 0], hits[i, 1]
        pieces[i, 2], pieces[i, 3] = normal_x, normal_y
    return pieces


def wall_of_each_beam(scan: Scan, beams: np.ndarray) -> np.ndarray:
    """(n, 4) where each beam met a straight piece of wall, x, y [m], and its normal, towards the sensor; world frame.

    NaN where it met none. Corners, ends, lone hits and walls met too flatly are left out: the next scan shows
    them only by chance.

    Args:
        scan: the scan.
        beams: (n, 3) x, y [m] and yaw [rad] of the sensor at each beam.
    """
    return _pieces(scan.ranges, beams, scan.angle_min, scan.angle_increment)
