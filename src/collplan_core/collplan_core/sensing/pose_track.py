"""Poses that agree with each other, as arrays: one more of them, an impact that they show, and the velocity.

All in one compiled call: a pose comes a hundred times a second, and around arrays of twenty numbers each call of numpy
costs more than what it computes.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Mocap, Robot
from collplan_core.sensing.impact_detection import (
    IMPACT_SPAN,
    NO_IMPACT,
    FittedImpact,
    ImpactLaw,
    find_impact,
    impact_law,
)

FEWEST = 3
"""Poses that a first velocity needs."""


class TrackLaw(NamedTuple):
    """What of a track is kept, and what for.

    Attributes:
        kept: span of the poses that are kept [s].
        velocity_window: span of those that are fitted for the velocity [s].
        slack: stamps are not spaced to the nanosecond: a pose so much older than a span still belongs to it [s].
        finds_impacts: whether impacts are looked for; impacts: what is one.
    """

    kept: float
    velocity_window: float
    slack: float
    finds_impacts: bool
    impacts: ImpactLaw


def track_law(robot: Robot, mocap: Mocap) -> TrackLaw:
    """The law for a robot and the motion capture that measures it."""
    kept, slack = max(IMPACT_SPAN * mocap.impact_window, mocap.velocity_window), 0.05 * mocap.velocity_window
    return TrackLaw(kept, mocap.velocity_window, slack, mocap.detect_impacts, impact_law(robot, mocap))


@njit
def with_pose(
    times: np.ndarray, points: np.ndarray, stamp: float, x: float, y: float, law: TrackLaw
) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s] and points (n, 2) [m] of a track with one more pose, without what is too old."""
    first = int(np.searchsorted(times, stamp - law.kept - law.slack))
    # at a low rate the window alone would not hold the poses a line needs
    first = max(min(first, len(times) - FEWEST + 1), 0)
    n = len(times) - first
    new_times, new_points = np.empty(n + 1), np.empty((n + 1, 2))
    new_times[:n] = times[first:]
    new_points[:n] = points[first:]
    new_times[n], new_points[n, 0], new_points[n, 1] = stamp, x, y
    return new_times, new_points


@njit
def with_pose_judged(
    times: np.ndarray, points: np.ndarray, begun: float, stamp: float, x: float, y: float, law: TrackLaw
) -> tuple[np.ndarray, np.ndarray, FittedImpact, float, float]:
    """A track with one more pose, and what it shows then.

    Returns:
        times (n,) [s] and points (n, 2) [m], after an impact from its centre on; the impact, or NO_IMPACT; the velocity
        [m/s], NaN until the first window is full.

    Args:
        times, points: the track so far.
        begun: stamp of its first pose, also where that is no longer kept [s].
        stamp, x, y: the pose [s, m].
        law: what is kept, and what for.
    """
    times, points = with_pose(times, points, stamp, x, y, law)
    impact = find_impact(times, points, law.impacts) if law.finds_impacts else NO_IMPACT
    if impact.score > 0.0:
        # in the place of the last pose before it; the arrays are of this call, nobody else has them
        first = impact.first_after - 1
        times[first], points[first, 0], points[first, 1] = impact.time, impact.x, impact.y
        times, points = times[first:], points[first:]
    vx, vy = _velocity(times, points, begun, law)
    return times, points, impact, vx, vy


@njit
def _velocity(times: np.ndarray, points: np.ndarray, begun: float, law: TrackLaw) -> tuple[float, float]:
    """[m/s]; NaN until the first window is full."""
    newest = times[-1]
    if newest - begun < law.velocity_window - law.slack or newest == times[0]:
        return math.nan, math.nan
    first = int(np.searchsorted(times, newest - law.velocity_window - law.slack))
    first = max(min(first, len(times) - FEWEST), 0)
    return _slope(times[first:], points[first:])


@njit
def _slope(times: np.ndarray, points: np.ndarray) -> tuple[float, float]:
    """Slope of the least-squares line through times (n,) and points (n, 2)."""
    middle = times.mean()
    total, x, y = 0.0, 0.0, 0.0
    for k in range(len(times)):
        t = times[k] - middle
        total += t * t
        x += t * points[k, 0]
        y += t * points[k, 1]
    return x / total, y / total
