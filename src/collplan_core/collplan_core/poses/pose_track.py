"""Poses that agree with each other, as arrays: one more of them, an impact that they show, and the velocity.

All in one compiled call: a pose comes a hundred times a second, and around arrays of twenty numbers each call of numpy
costs more than what it computes.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Mocap, Robot
from collplan_core.poses.impact_detection import IMPACT_SPAN, NO_IMPACT, ImpactLaw, find_impact, impact_law

FEWEST = 3
"""Poses that a first velocity needs."""
BURST = 0.03
"""Poses nearer than this to the first of a burst are one pose with it, in velocity windows: the newest alone is of the
time at which they were stamped."""
PAUSE = 3.0
"""Silence after which a burst may have begun, in mean intervals of the poses before: its first pose is old."""


class TrackLaw(NamedTuple):
    """Spans of a track that are kept, and their uses."""

    kept: float  # span of the poses that are kept [s]
    velocity_window: float  # span of those that are fitted for the velocity [s]
    slack: float  # stamps are not spaced to the nanosecond: a pose so much older than a span still belongs to it [s]
    finds_impacts: bool  # whether impacts are detected
    impacts: ImpactLaw  # the criteria for one


def track_law(robot: Robot, mocap: Mocap, shown: float = 0.0) -> TrackLaw:
    """The law for a robot, the motion capture that measures it, and the acceleration that it has shown [m/s^2]."""
    kept, slack = max(IMPACT_SPAN * mocap.impact_window, mocap.velocity_window), 0.05 * mocap.velocity_window
    return TrackLaw(kept, mocap.velocity_window, slack, mocap.detect_impacts, impact_law(robot, mocap, shown))


class FittedMotion(NamedTuple):
    """The least-squares line through the poses of the velocity window."""

    vx: float  # vx, vy: its slope [m/s]; NaN until the first window is full, as all that follows
    vy: float
    yaw_rate: float  # [rad/s]
    delay: float  # time before the newest pose at which the slope is the velocity [s]
    spread: float
    """Sum of the squared times around their mean [s^2]: noise of the poses over its root is that of the slope."""


NO_MOTION = FittedMotion(math.nan, math.nan, math.nan, math.nan, math.nan)


@njit
def with_pose(
    times: np.ndarray, poses: np.ndarray, stamp: float, x: float, y: float, yaw: float, law: TrackLaw
) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s] and poses (n, 3) of a track with one more pose, without what is too old; yaws go on unwrapped."""
    first = int(np.searchsorted(times, stamp - law.kept - law.slack))
    # at a low rate the window alone would not hold the poses a line needs
    first = max(min(first, len(times) - FEWEST + 1), 0)
    n = len(times) - first
    yaw_before = poses[-1, 2] if len(times) else yaw
    if n > 0 and stamp - times[-1] < BURST * law.velocity_window:
        n, stamp = n - 1, times[-1]
    new_times, new_poses = np.empty(n + 1), np.empty((n + 1, 3))
    new_times[:n] = times[first : first + n]
    new_poses[:n] = poses[first : first + n]
    if len(times):
        yaw = yaw_before + (yaw - yaw_before + math.pi) % math.tau - math.pi
    new_times[n], new_poses[n, 0], new_poses[n, 1], new_poses[n, 2] = stamp, x, y, yaw
    return new_times, new_poses


@njit
def with_pose_judged(
    times: np.ndarray, poses: np.ndarray, track: tuple, stamp: float, x: float, y: float, yaw: float, law_fields: tuple
) -> tuple[np.ndarray, np.ndarray, tuple, tuple]:
    """A track with one more pose [s, m, rad], and what it shows then.

    What goes in and out are plain tuples, which cost a fifth of named ones to hand over. Out: times (n,) [s] and poses
    (n, 3), after an impact from its centre on; fields of the impact or of NO_IMPACT; those of the motion, or NO_MOTION.

    Args:
        track: stamp of its first pose, also where that is no longer kept [s], and whether poses come in bursts.
        law_fields: fields of a TrackLaw, and in it of an ImpactLaw.
    """
    kept, velocity_window, slack, finds_impacts, impact_fields = law_fields
    law = TrackLaw(kept, velocity_window, slack, finds_impacts, ImpactLaw(*impact_fields))
    begun, bursts = track
    times, poses = with_pose(times, poses, stamp, x, y, yaw, law)
    # the burst that goes on shows where the robot was, stamped now
    judged = len(times) - (1 if bursts or _is_after_a_pause(times) else 0)
    may_be_one = law.finds_impacts and judged >= FEWEST and times[-1] == stamp
    impact = find_impact(times[:judged], poses[:judged], law.impacts) if may_be_one else NO_IMPACT
    if impact.score > 0.0:
        # in the place of the last pose before it; the arrays belong to this call alone
        first = impact.first_after - 1
        share = (impact.time - times[first]) / (times[first + 1] - times[first])
        poses[first, 2] += share * (poses[first + 1, 2] - poses[first, 2])
        times[first], poses[first, 0], poses[first, 1] = impact.time, impact.x, impact.y
        times, poses = times[first:], poses[first:]
    motion = _motion(times, poses, begun, law)
    found = impact.score, impact.first_after, impact.time, impact.x, impact.y
    change = impact.before_x, impact.before_y, impact.change_x, impact.change_y
    return times, poses, (*found, *change), (motion.vx, motion.vy, motion.yaw_rate, motion.delay, motion.spread)


@njit
def _is_after_a_pause(times: np.ndarray) -> bool:
    n = len(times)
    return n > FEWEST and times[-1] - times[-2] > PAUSE * (times[-2] - times[0]) / (n - 2)


@njit
def _motion(times: np.ndarray, poses: np.ndarray, begun: float, law: TrackLaw) -> FittedMotion:
    """NO_MOTION until the first window is full."""
    newest = times[-1]
    if newest - begun < law.velocity_window - law.slack or newest == times[0]:
        return NO_MOTION
    first = int(np.searchsorted(times, newest - law.velocity_window - law.slack))
    first = max(min(first, len(times) - FEWEST), 0)
    return _fitted(times[first:], poses[first:])


@njit
def _fitted(times: np.ndarray, poses: np.ndarray) -> FittedMotion:
    """The least-squares line through times (n,) and poses (n, 3)."""
    middle = times.mean()
    total, x, y, yaw = 0.0, 0.0, 0.0, 0.0
    for k in range(len(times)):
        t = times[k] - middle
        total += t * t
        x += t * poses[k, 0]
        y += t * poses[k, 1]
        yaw += t * poses[k, 2]
    return FittedMotion(x / total, y / total, yaw / total, times[-1] - middle, total)
