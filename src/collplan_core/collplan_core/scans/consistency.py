"""Comparison of a scan with the walls of earlier scans: which are missing, and how late it is."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.scans.remembered_walls import NEAR
from collplan_core.sight_lines import directions_of, is_full_turn, last_before, place_towards

GAP = 0.07
"""All beams towards a wall must end so far beyond it for it to be missing, or one so far before it for it to be hidden
[m]: five times the noise of the difference of two ranges, of 0.01 m each."""
SIDEWAYS, TURNED = 0.03, math.radians(1.0)
"""Beams within these of the direction of a wall may show it [m, rad]: the errors of poses."""
EDGE_ON = 0.2
"""A wall that is met at a smaller sine is not expected."""
FACING = 0.7
"""Least cosine between the motion and the way into a wall for it to lie ahead."""
ACROSS = 0.5
"""Least cosine between the motion and the normal of a wall for it to show how late a scan is."""
PARALLEL = 0.9
"""Least cosine between the normals of two pieces of wall for them to be the same one: else a corner hides it by now."""
MOVING = 0.2
"""Speed from which on walls lie ahead, a late scan shows, and what is no wall may not be missing either [m/s]: at rest
a lie does no harm, and people walk off."""
LONGEST_DELAY = 0.6
"""Walls that are farther off than the motion of this time are others [s]."""


class Consistency(NamedTuple):
    """Result of the comparison of a scan with walls seen before."""

    expected: int
    missing: int
    """expected, missing: number of walls that the scan must show, as nothing in it hides them; number not shown."""
    expected_ahead: int  # expected_ahead, missing_ahead: the same for walls that the robot moves towards
    missing_ahead: int
    n_delays: int
    delay: float
    """n_delays, delay: age of the scan's content beyond its stamp [s], median over so many recent walls; NaN for 0."""
    towards_missing: np.ndarray  # (n,) bool, whether a beam goes towards a wall that is missing


@njit
def _beam_towards(x: float, y: float, beams: np.ndarray, first: float, step: float) -> int:
    """The beam whose direction is nearest to that of a point [m]; -1 where no beam goes there."""
    n = len(beams)
    k = int(round(place_towards(x, y, beams, first, step, n // 2)))
    if k >= n:
        return k % n if is_full_turn(n, step) else -1
    return k


@njit
def _least_of_runs(ranges: np.ndarray, closed: bool) -> np.ndarray:
    """(l, n + 2 (n // 8)) the least range in each run of 1, 2, 4, ... beams, from beam -(n // 8) on [m]."""
    # inf where none of them measured anything, as beyond the ends of a scan that is not closed.
    n, beside = len(ranges), len(ranges) // 8
    levels, length = 1, n + 2 * beside
    while 2**levels <= 2 * beside + 1:
        levels += 1
    least = np.full((levels, length), math.inf)
    for i in range(length):
        # below 0 counts from the end by itself
        k = i - beside if i - beside < n else i - beside - n
        if (closed or 0 <= i - beside < n) and ranges[k] < math.inf:
            least[0, i] = ranges[k]
    for level in range(1, levels):
        half = 2 ** (level - 1)
        for i in range(length - 2 * half + 1):
            least[level, i] = min(least[level - 1, i], least[level - 1, i + half])
    return least


@njit
def _nearest_range(least: np.ndarray, begin: int, count: int) -> float:
    """The least range of so many beams by `_least_of_runs` [m]: two of its runs cover them."""
    level, run = 0, 1
    while 2 * run <= count:
        level, run = level + 1, 2 * run
    return min(least[level, begin], least[level, begin + count - run])


@njit
def scan_consistency(
    walls: np.ndarray,
    recent: int,
    now: np.ndarray,
    ranges: np.ndarray,
    masked: np.ndarray,
    beams: np.ndarray,
    scan_limits: tuple,
    velocity: tuple,
) -> Consistency:
    """Compares a scan with walls that earlier scans showed.

    A scan that shows what was seen a while ago, though it is stamped now, shows each wall off by what the robot has
    moved since: of each wall the delay is the distance over the speed towards it. A wall behind that a parallel one has
    come in front of looks the same. In the time of the recent walls that happens to few.

    Args:
        walls: (m, 5) points of walls, their normals, and 0 for what is no wall, of scans before.
        recent: the row from which on they are of the last of these, which alone tell the delay.
        now: (n, 5) the same of each beam of the scan, of `wall_of_each_beam`; ranges: (n,) [m].
        masked: (n,) whether a beam is masked: no wall is expected where it looks.
        beams: (n, 3) x, y [m] and yaw [rad] of the sensor at each beam.
        scan_limits: angle_min, angle_increment [rad], range_min, range_max [m]; velocity: (2,) of the robot [m/s].
    """
    n = len(ranges)
    first, step, nearest_seen, farthest_seen = scan_limits
    nearest_seen, farthest_seen = max(nearest_seen, 0.01), min(farthest_seen, NEAR)
    closed = is_full_turn(n, step)
    speed = math.hypot(velocity[0], velocity[1])
    expected, missing, expected_ahead, missing_ahead, n_delays = 0, 0, 0, 0, 0
    # between beams k and k + 1 the one nearest to a wall changes
    changes, least, k = directions_of(beams, first + 0.5 * step, step)[:-1], _least_of_runs(ranges, closed), 0
    delays = np.empty(len(walls))
    towards_missing = np.zeros(n, dtype=np.bool_)
    for j in range(len(walls)):
        if speed < MOVING and walls[j, 4] == 0.0:
            continue
        x, y, normal_x, normal_y = walls[j, 0], walls[j, 1], walls[j, 2], walls[j, 3]
        k = 1 + last_before(changes, k - 1, x - beams[0, 0], y - beams[0, 1])
        if k == 0:
            k = _beam_towards(x, y, beams, first, step)
        if k < 0 or masked[k]:
            continue
        dx, dy = x - beams[k, 0], y - beams[k, 1]
        distance = math.hypot(dx, dy)
        if not nearest_seen <= distance <= farthest_seen or -(dx * normal_x + dy * normal_y) < EDGE_ON * distance:
            continue
        closing = -(velocity[0] * normal_x + velocity[1] * normal_y)
        is_parallel = now[k, 2] * normal_x + now[k, 3] * normal_y >= PARALLEL
        if j >= recent and speed >= MOVING and abs(closing) >= ACROSS * speed and is_parallel:
            beyond = (x - now[k, 0]) * normal_x + (y - now[k, 1]) * normal_y
            if abs(beyond) <= GAP + LONGEST_DELAY * speed:
                delays[n_delays] = beyond / closing
                n_delays += 1
        w = int(min(math.ceil((SIDEWAYS / distance + TURNED) / abs(step)), n // 8))
        nearest = _nearest_range(least, n // 8 + k - w, 2 * w + 1)
        if nearest < distance - GAP:
            continue
        gone = nearest > distance + GAP
        expected += 1
        missing += gone
        towards_missing[k] |= gone
        if speed >= MOVING and closing >= FACING * speed:
            expected_ahead += 1
            missing_ahead += gone
    delay = float(np.median(delays[:n_delays])) if n_delays > 0 else math.nan
    return Consistency(expected, missing, expected_ahead, missing_ahead, n_delays, delay, towards_missing)
