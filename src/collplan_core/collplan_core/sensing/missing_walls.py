"""How much of the walls seen before a scan no longer shows."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.scan import Scan
from collplan_core.sensing.seen_walls import NEAR, is_full_turn

GAP = 0.07
"""Distance beyond a wall at which a beam must end for the wall to be missing [m]: above the noise of two ranges of
0.01 m and two poses, below what the robot goes at 0.5 m/s in 0.15 s."""
SIDEWAYS, TURNED = 0.03, math.radians(1.0)
"""Beams within these of the direction of a wall may show it [m, rad]: what poses are off."""
EDGE_ON = 0.2
"""A wall that is met at a smaller sine is not expected."""
FACING = 0.7
"""Least cosine between the motion and the way into a wall for it to lie ahead."""
MOVING = 0.2
"""Speed from which on walls lie ahead [m/s]."""


class Missing(NamedTuple):
    """Numbers of walls seen before: those that the scan must show and those of them it does not; the same ahead."""

    expected: int
    missing: int
    expected_ahead: int
    missing_ahead: int


@njit
def _beam_towards(x: float, y: float, beams: np.ndarray, first: float, step: float) -> int:
    """The beam whose direction is nearest to that of a point [m]; -1 where no beam goes there."""
    n = len(beams)
    k = n // 2
    for _ in range(3):  # a robot that moves during the sweep is elsewhere at each beam
        bearing = math.atan2(y - beams[k, 1], x - beams[k, 0]) - beams[k, 2] - first
        turned = bearing % (2.0 * math.pi) if step > 0.0 else -bearing % (2.0 * math.pi)
        k = int(round(turned / abs(step)))
        if k >= n:
            if not is_full_turn(n, step):
                return -1
            k %= n
    return k


@njit
def _farthest_possible(ranges: np.ndarray, k: int, w: int, closed: bool) -> float:
    """The least range within w beams of beam k [m]; inf where none of them measured anything."""
    n = len(ranges)
    least = math.inf
    for i in range(k - w, k + w + 1):
        if not closed and (i < 0 or i >= n):
            continue
        if ranges[i % n] < least:
            least = ranges[i % n]
    return least


@njit
def _count(
    walls: np.ndarray, ranges: np.ndarray, beams: np.ndarray, first: float, step: float, limits: tuple, velocity: tuple
) -> Missing:
    n = len(ranges)
    closed = is_full_turn(n, step)
    speed = math.hypot(velocity[0], velocity[1])
    expected, missing, expected_ahead, missing_ahead = 0, 0, 0, 0
    for j in range(len(walls)):
        x, y, normal_x, normal_y = walls[j, 0], walls[j, 1], walls[j, 2], walls[j, 3]
        k = _beam_towards(x, y, beams, first, step)
        if k < 0:
            continue
        dx, dy = x - beams[k, 0], y - beams[k, 1]
        distance = math.hypot(dx, dy)
        if not limits[0] <= distance <= min(limits[1], NEAR) or -(dx * normal_x + dy * normal_y) < EDGE_ON * distance:
            continue
        w = int(min(math.ceil((SIDEWAYS / distance + TURNED) / abs(step)), n // 8))
        gone = _farthest_possible(ranges, k, w, closed) > distance + GAP
        expected += 1
        missing += gone
        if speed >= MOVING and -(velocity[0] * normal_x + velocity[1] * normal_y) >= FACING * speed:
            expected_ahead += 1
            missing_ahead += gone
    return Missing(expected, missing, expected_ahead, missing_ahead)


def count_missing(walls: np.ndarray, scan: Scan, beams: np.ndarray, velocity: np.ndarray) -> Missing:
    """Counts the walls that a scan must show, as nothing that it shows hides them, and those it does not.

    Args:
        walls: (m, 4) points of walls and their normals, of `seen_walls`.
        scan: the scan.
        beams: (n, 3) x, y [m] and yaw [rad] of the robot at each beam.
        velocity: (2,) of the robot [m/s]: walls that it moves towards lie ahead.
    """
    limits = max(scan.range_min, 0.01), scan.range_max
    moving = float(velocity[0]), float(velocity[1])
    return _count(walls, scan.ranges, beams, scan.angle_min, scan.angle_increment, limits, moving)
