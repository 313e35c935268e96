"""Measures how well pairs of scans agree under an assumed LIDAR mount, stamp delay and beam order."""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.mounting.driven import Driven

FAR = 0.3
"""Distance beyond which returns count alike [m]: people walk, and what one scan sees is hidden from the other."""
JOINED = 0.15
"""Neighbouring returns that are nearer to one another are one surface [m]."""
SPARED = 4
"""Step between the beams of the later scan that are compared."""


class Mount(NamedTuple):
    """An assumption: place x, y [m] and heading [rad] of the LIDAR on the robot, and its times.

    `late` is the start of the sweep after the stamp [s]; `sweep` is 1 where beams follow in order, -1 where backwards,
    and 0 where all are of one instant; `mirrored` is whether angles count clockwise.
    """

    late: float
    x: float
    y: float
    yaw: float
    sweep: int = 0
    mirrored: bool = False


def disagreements(driven: Driven, scans: np.ndarray, mount: Mount) -> np.ndarray:
    """(p,) mean distance of the later scan's returns from the earlier one's surfaces [m], of pairs (p, 2)."""
    angles = mount.yaw + (-driven.angles if mount.mirrored else driven.angles)
    beams = np.arange(len(angles))
    offsets = mount.late + driven.between * (beams if mount.sweep > 0 else beams[::-1]) * abs(mount.sweep)
    place = float(mount.x), float(mount.y)
    return np.asarray(
        _disagreements((driven.times, driven.poses), (driven.stamps, driven.ranges), scans, angles, offsets, place)
    )


@njit
def _disagreements(
    way: tuple[np.ndarray, np.ndarray],
    taken: tuple[np.ndarray, np.ndarray],
    scans: np.ndarray,
    angles: np.ndarray,
    offsets: np.ndarray,
    place: tuple[float, float],
) -> np.ndarray:
    found = np.full(len(scans), FAR)
    for p in range(len(scans)):
        a = _points(way, taken[0][scans[p, 0]] + offsets, taken[1][scans[p, 0]], angles, place, 1)
        b = _points(way, taken[0][scans[p, 1]] + offsets, taken[1][scans[p, 1]], angles, place, SPARED)
        total = 0.0
        for k in range(len(b)):
            total += _distance(a, b[k, 0], b[k, 1])
        if len(a) > 1 and len(b) > 0:
            found[p] = total / len(b)
    return found


@njit
def _points(
    way: tuple[np.ndarray, np.ndarray],
    times: np.ndarray,
    ranges: np.ndarray,
    angles: np.ndarray,
    place: tuple[float, float],
    step: int,
) -> np.ndarray:
    """(j, 2) returns of every `step`-th beam in the world [m]."""
    at, poses = way
    points, count, n = np.empty((len(ranges), 2)), 0, len(at)
    for k in range(0, len(ranges), step):
        if not np.isfinite(ranges[k]):
            continue
        j = min(max(np.searchsorted(at, times[k]), 1), n - 1)
        share = min(max((times[k] - at[j - 1]) / (at[j] - at[j - 1]), 0.0), 1.0)
        x, y, yaw = poses[j - 1] + share * (poses[j] - poses[j - 1])
        ahead = place[0] + ranges[k] * np.cos(angles[k])
        left = place[1] + ranges[k] * np.sin(angles[k])
        c, s = np.cos(yaw), np.sin(yaw)
        points[count, 0], points[count, 1] = x + c * ahead - s * left, y + s * ahead + c * left
        count += 1
    return points[:count]


@njit
def _distance(points: np.ndarray, x: float, y: float) -> float:
    """Distance of (x, y) from the surfaces through points in order, at most FAR [m]."""
    nearest, at = FAR * FAR, -1
    for k in range(len(points)):
        dx, dy = points[k, 0] - x, points[k, 1] - y
        square = dx * dx + dy * dy
        if square < nearest:
            nearest, at = square, k
    if at < 0:
        return FAR
    for k in (at - 1, at):
        if k < 0 or k + 1 >= len(points):
            continue
        ux, uy = points[k + 1, 0] - points[k, 0], points[k + 1, 1] - points[k, 1]
        length = ux * ux + uy * uy
        if not 0.0 < length < JOINED * JOINED:
            continue
        share = ((x - points[k, 0]) * ux + (y - points[k, 1]) * uy) / length
        if 0.0 < share < 1.0:
            dx, dy = points[k, 0] + share * ux - x, points[k, 1] + share * uy - y
            nearest = min(nearest, dx * dx + dy * dy)
    return float(np.sqrt(nearest))
