"""Search for the beam of a scan that goes towards a point, where each beam has its own origin."""

import math

import numpy as np

from collplan_core.jit import njit

TRIES = 4
"""Looks from beam to beam: a sensor that moves during its sweep is elsewhere at each."""
WALK = 12
"""Largest number of beams from a guess that are tried one by one."""
TIE = 1e-9
"""Least sine between a point and a beam beside it for a cross product to tell as the bearing does, whatever is rounded.
"""


@njit
def is_full_turn(n: int, step: float) -> bool:
    """Returns whether the first of n beams, `step` [rad] apart, follows the last one."""
    return abs(step) * (n + 0.5) > 2.0 * math.pi


@njit
def repeats_first(n: int, step: float) -> bool:
    """Returns whether the last of n beams, `step` [rad] apart, has the direction of the first one."""
    return abs(step) * (n - 1) > 2.0 * math.pi - 0.5 * abs(step)


@njit
def _is_same_pose(beams: np.ndarray, i: int, k: int) -> bool:
    return beams[i, 0] == beams[k, 0] and beams[i, 1] == beams[k, 1] and beams[i, 2] == beams[k, 2]


@njit
def _within_turn(angle: float) -> float:
    """The angle in [0, 2 pi) [rad]; where it is off by one turn, as almost always, in less time than by a division."""
    if 0.0 <= angle < 2.0 * math.pi:
        return angle
    return angle + 2.0 * math.pi if -2.0 * math.pi < angle < 0.0 else angle % (2.0 * math.pi)


@njit
def place_towards(x: float, y: float, beams: np.ndarray, first: float, step: float, guess: int) -> float:
    """Returns the number of beams, with fraction, from the first one to the direction of a point [m]; 0 to 2 pi / step.

    Args:
        beams: (n, 3) x, y [m] and yaw [rad] of the sensor at each beam.
        first: direction of the first beam, seen from the sensor; step: angle from beam to beam [rad].
        guess: number of a beam that goes about there.
    """
    n, k, place = len(beams), guess, 0.0
    for _ in range(TRIES):
        bearing = math.atan2(y - beams[k, 1], x - beams[k, 0]) - beams[k, 2] - first
        turned = _within_turn(bearing if step > 0.0 else -bearing)
        place = turned / abs(step)
        nearest = int(round(place))
        if nearest >= n:  # between the last beam and the first, or where no beam goes
            nearest = n - 1 if place - (n - 1) < 2.0 * math.pi / abs(step) - place else 0
        # beams with one origin give the same again
        if nearest == k or _is_same_pose(beams, nearest, k):
            break
        k = nearest
    return place


@njit
def directions_of(beams: np.ndarray, first: float, step: float) -> np.ndarray:
    """(n, 2) the directions of beams (n, 3) as in `place_towards`; (0, 2) where they differ in pose, or overlap.

    They are turned on from beam to beam: what that rounds is far below TIE.
    """
    found, ahead = np.empty((len(beams), 2)), first + beams[0, 2]
    if not 0.0 < step * (len(beams) - 1) < 2.0 * math.pi:
        return found[:0]
    x, y, c, s = math.cos(ahead), math.sin(ahead), math.cos(step), math.sin(step)
    for i in range(len(beams)):
        if not _is_same_pose(beams, i, 0):
            return found[:0]
        found[i, 0], found[i, 1] = x, y
        x, y = c * x - s * y, s * x + c * y
    return found


@njit
def last_before(directions: np.ndarray, guess: int, x: float, y: float) -> int:
    """The last of the directions before a point, seen from their origin [m], by a walk from a guess on.

    It takes no arc tangent. -1 where the point is near to a direction, far from the guess or beyond the last one:
    `place_towards` tells there.
    """
    k, tie = guess, TIE * (abs(x) + abs(y))
    for _ in range(WALK):
        if not 0 <= k < len(directions) - 1 or directions[k, 0] * x + directions[k, 1] * y <= 0.0:
            return -1
        past = directions[k, 0] * y - directions[k, 1] * x
        beyond = directions[k + 1, 0] * y - directions[k + 1, 1] * x
        if past > tie and beyond < -tie:
            return k
        if abs(past) <= tie or abs(beyond) <= tie:
            return -1
        k += 1 if past > 0.0 else -1
    return -1
