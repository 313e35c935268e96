"""What ranges mean: beams that meet the robot's own posts, and what a range of 0 or +Inf stands for."""

import math
from collections.abc import Sequence

import numpy as np

from collplan_core.mounting.agreement import Mount
from collplan_core.mounting.driven import Driven
from collplan_core.scan import Scan

TURNED, FEWEST, CLOSE = 0.1, 20, 0.6
"""Turn between two scans that are compared [rad], their number, and the farthest post of the robot's own [m]: a wall
stays at its range beside a straight way, and never through a turn."""
STEADY, SHARE = 0.02, 0.93
"""Most by which the range of a post is off [m], and in what share of the scans."""
SCANS, EARLIER, BEAMS, SPAN = 40, 8, 40, 2.0
"""Scans whose codes are looked at, scans beside each that tell what stands there, beams of each, and the time [s]."""
BESIDE, RETURNS = 0.03, 3
"""A surface is in a beam's way where so many returns of other scans are within this of it [m]."""
CODES, MISSED, NEVER = 100, 0.1, 0.01
"""Beams with a code from which on it is judged, and shares of them in whose way a surface was measured by others."""


def own_posts(scans: Sequence[Scan], way: np.ndarray) -> tuple[float, ...] | None:
    """Angles from, to, from, to, ... of the beams that end at one short range all through turns; None without turns.

    The scans are as their messages count angles and beams, all of one length; the way is (n, 4) stamp [s], x, y [m] and
    yaw, not wrapped [rad].
    """
    yaws, chosen = np.interp([scan.stamp for scan in scans], way[:, 0], way[:, 3]), [0]
    for k, yaw in enumerate(yaws.tolist()):
        if abs(yaw - yaws[chosen[-1]]) > TURNED:
            chosen.append(k)
    if len(chosen) < FEWEST or np.ptp(yaws) < 2.0:
        return None
    ranges = np.array([scans[k].ranges for k in chosen])
    ranges[~np.isfinite(ranges)] = math.inf
    middle = np.median(ranges, axis=0)
    near = middle < CLOSE
    steady = np.abs(ranges[:, near] - middle[near]) < STEADY
    near[near] = steady.mean(axis=0) >= SHARE
    ends = np.flatnonzero(np.diff(near, prepend=False, append=False)).reshape(-1, 2)
    angles, step = scans[0].angles, abs(scans[0].angle_increment)
    # the beams beside a post meet its edges
    return tuple(
        round(float(each), 4)
        for first, last in ends
        for each in (min(angles[first], angles[last - 1]) - step, max(angles[first], angles[last - 1]) + step)
    )


def meaning_of(code: float, raw: np.ndarray, driven: Driven, mount: Mount, reach: tuple[float, float]) -> str:
    """What a code among the ranges stands for: `lost`, `near` or `free`; "" where the drive does not show it.

    The code is inf, or -inf for a range of 0; `raw` (m, k) are the ranges as the messages of `driven` give them,
    `reach` the shortest and longest range of the LIDAR [m].
    """
    coded = np.flatnonzero((raw == code).sum(axis=1) > 0)
    coded = coded[(driven.stamps[coded] > driven.times[0]) & (driven.stamps[coded] < driven.times[-1])]
    random, expected = np.random.default_rng(0), []
    for at in coded[np.linspace(0, len(coded) - 1, min(SCANS, len(coded))).astype(int)]:
        beams = np.flatnonzero(raw[at] == code)
        beams = random.choice(beams, min(BEAMS, len(beams)), replace=False)
        beside = np.flatnonzero(np.abs(driven.stamps - driven.stamps[at]) < SPAN)
        beside = beside[np.linspace(0, len(beside) - 1, min(EARLIER, len(beside))).astype(int)]
        points = np.concatenate([_returns(driven, k, mount) for k in beside])
        expected.append(_first_met(points, *(each[beams] for each in _rays(driven, at, mount))))
    ranges = np.concatenate(expected) if expected else np.zeros(0)
    if len(ranges) < CODES:
        return ""
    shortest, longest = reach
    near = float((ranges < shortest).mean())
    missed = float(((ranges >= shortest + BESIDE) & (ranges < 0.9 * longest)).mean())
    if missed > MISSED:
        return "lost"
    if near > 0.5:
        return "near"
    return "free" if missed < NEVER and near < NEVER else ""


def _rays(driven: Driven, at: int, mount: Mount) -> tuple[np.ndarray, np.ndarray]:
    """(k, 2) origins [m] and (k,) bearings [rad] of a scan's beams in the world."""
    order = np.arange(len(driven.angles))
    order = (order if mount.sweep > 0 else order[::-1]) * abs(mount.sweep)
    times = driven.stamps[at] + mount.late + driven.between * order
    x, y, yaw = (np.interp(times, driven.times, column) for column in driven.poses.T)
    c, s = np.cos(yaw), np.sin(yaw)
    origins = np.column_stack([x + c * mount.x - s * mount.y, y + s * mount.x + c * mount.y])
    return origins, yaw + mount.yaw + (-driven.angles if mount.mirrored else driven.angles)


def _returns(driven: Driven, at: int, mount: Mount) -> np.ndarray:
    """(j, 2) points that a scan met [m]."""
    origins, bearings = _rays(driven, at, mount)
    met = np.isfinite(driven.ranges[at])
    ways = np.column_stack([np.cos(bearings[met]), np.sin(bearings[met])])
    return np.asarray(origins[met] + driven.ranges[at][met, None] * ways)


def _first_met(points: np.ndarray, origins: np.ndarray, bearings: np.ndarray) -> np.ndarray:
    """(n,) distance along each beam at which RETURNS of the points are in its way [m]; inf where fewer are."""
    if len(points) < RETURNS:
        return np.full(len(bearings), math.inf)
    apart = points - origins[:, None]
    c, s = np.cos(bearings)[:, None], np.sin(bearings)[:, None]
    along, aside = apart[..., 0] * c + apart[..., 1] * s, apart[..., 1] * c - apart[..., 0] * s
    along[(np.abs(aside) > BESIDE) | (along < BESIDE)] = math.inf
    return np.partition(along, RETURNS - 1, axis=1)[:, RETURNS - 1]
