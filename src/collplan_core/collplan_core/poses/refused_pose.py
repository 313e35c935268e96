"""Reasons for refused poses in words: what came, what was expected, and the parameter to look at."""

import math

from collplan_core.parameters import Settings
from collplan_core.poses.pose_filter import LEAP, NOT_FINITE, SPEED, STAMP, FilterMemory, PoseSample, speed_limit
from collplan_core.poses.six_degrees import TILT, YAW

CLOCK = "clock"
"""Reason given beside accepted poses whose stamps do not run as time does."""
CLOCK_RATIO = 1.5
"""Stamps that run faster or slower than this multiple of the local time cannot be seconds."""
SLOWEST = 50.0
"""Stamps that are slower than this are not of a simulation, but in another unit."""


def described_pose(sample: PoseSample) -> str:
    """Returns a pose in words."""
    place = ", ".join(f"{value:.3f}" for value in (*sample.position.tolist(), sample.height))
    return f"pose {place}, yaw {sample.yaw:.2f}, tilt {sample.tilt:.2f} at {sample.stamp:.3f}"


def why_refused(reason: str, sample: PoseSample, before: FilterMemory, settings: Settings, shown: float) -> str:
    """Returns why a pose was refused by a filter with the memory `before`, and `reason` as in FilterResult.refused.

    `shown` is the speed that the poses show, for the reason SPEED [m/s].
    """
    mocap, newest = settings.mocap, before.track.newest
    if reason == NOT_FINITE:
        return f"{described_pose(sample)}, expected finite numbers"
    if reason == TILT:
        limit = f"expected at most {mocap.max_tilt:.2f} (mocap.max_tilt): mocap.axes ({mocap.axes})?"
        return f"tilted by {sample.tilt:.2f} rad, {limit}"
    if newest is None:
        return described_pose(sample)
    away, silence = math.dist(sample.position, newest.position), sample.stamp - newest.stamp
    if reason == STAMP:
        return (
            f"{sample.stamp:.3f} s is not later than the last, {newest.stamp:.3f} s: does the receiver stamp its poses?"
        )
    if reason == LEAP:
        limit = f"expected at most robot.max_speed {settings.robot.max_speed:g} m/s: mocap.units ({mocap.units})?"
        return f"{away:.2f} m within {silence:.3f} s to {described_pose(sample)}, {limit}"
    if reason == YAW:
        turned = math.degrees(math.remainder(sample.yaw - newest.yaw, math.tau))
        limit = f"expected at most mocap.max_spin {mocap.max_spin:g} rad/s: are the markers nearly symmetric?"
        return f"turned by {turned:.0f} degrees within {silence:.3f} s, {limit}"
    if reason == SPEED:
        return _too_fast(sample, before, settings, shown)
    x, y = sample.position.tolist()
    lift = before.floor.lift(x, y, sample.height)
    return f"{lift:.3f} m off the floor, expected at most {mocap.max_lift:g} (mocap.max_lift): mocap.axes, mocap.units?"


def _too_fast(sample: PoseSample, before: FilterMemory, settings: Settings, shown: float) -> str:
    times = before.track.times[before.track.times >= sample.stamp - settings.mocap.velocity_window]
    span = sample.stamp - float(times[0]) if len(times) else 0.0
    limit = speed_limit(settings)
    if shown > limit:
        found = f"{len(times) + 1} poses within {1000.0 * span:.1f} ms move at {shown:.2f} m/s"
    else:
        found = f"poses moved faster than {limit:.2f} m/s less than {settings.mocap.relocation_time:g} s ago"
    return f"{found}, expected at most {limit:.2f}: does the receiver stamp at receipt (mocap.rate)? mocap.units?"


def why_clock_is_wrong(stamps: float, elapsed: float) -> str:
    """Returns why stamps that advance by `stamps` [s] in `elapsed` [s] are wrong; empty if they are not."""
    if math.isnan(elapsed) or elapsed / CLOCK_RATIO < stamps < elapsed * CLOCK_RATIO:
        return ""
    what = "in which unit are those of header.stamp?"
    if elapsed / SLOWEST < stamps < elapsed:
        what = f"a simulation? then use_sim_time: true for every node; else {what}"
    return f"{stamps:.3g} s of stamps in {elapsed:.2f} s, expected as many: {what}"
