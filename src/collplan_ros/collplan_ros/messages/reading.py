"""Scans and plans out of messages, by the attributes of these alone.

A message decoded from a recording will do as well as one of rclpy's, and no ROS is needed.
"""

import math
from typing import Any

import numpy as np

from collplan_core.parameters import ScanInput
from collplan_core.plan import Plan, timed_path
from collplan_core.scan import Scan, ScanError

NANOSECONDS = 1_000_000_000
SHIPPED = ScanInput()
ZERO = {"near": 0.0, "lost": math.nan, "free": math.inf}
"""What is made of a range of 0: one that is near stays, being below range_min."""


class MessageError(ValueError):
    """A message that cannot be used; the text names the field, the value and what was expected."""


class PathError(MessageError):
    """A path that holds no usable plan."""


def seconds_from_stamp(stamp: Any) -> float:
    """The time of a Time, or a Duration [s]: exact to the nanosecond below 100 days, to 0.2 us in Unix time."""
    return int(stamp.sec) + int(stamp.nanosec) / NANOSECONDS


def check_frame(field: str, got: str, expected: str) -> None:
    """Raises MessageError where a field names another frame."""
    if got != expected:
        raise MessageError(f"{field}: got frame {got!r}, expected {expected!r}")


def check_finite(field: str, *values: float) -> None:
    """Raises MessageError where a value is not finite."""
    if not all(math.isfinite(value) for value in values):
        raise MessageError(f"{field}: got {', '.join(f'{v:g}' for v in values)}, expected finite numbers")


def scan_from_message(message: Any, frame: str, taken: ScanInput = SHIPPED) -> Scan:
    """The scan in a LaserScan, as its sensor has it: where that is on the robot is not in it.

    Args:
        message: the LaserScan.
        frame: the robot's frame, which the message names where `taken.frame` says nothing else.
        taken: how it is to be read.

    Raises:
        ScanError: another frame, angles that do not fit the number of ranges, or values that `Scan` refuses.
    """
    expected = taken.frame or frame
    if message.header.frame_id != expected:
        key = "scan.frame" if taken.frame else "frames.base, where scan.frame is empty"
        raise ScanError(f"header.frame_id: got {message.header.frame_id!r}, expected {expected!r} ({key})")
    first, last, step = float(message.angle_min), float(message.angle_max), float(message.angle_increment)
    ranges = _ranges(message, taken)
    # devices disagree on whether angle_max is the last beam's angle or one step further
    if not abs(first + step * (len(ranges) - 1) - last) <= 1.5 * abs(step):
        raise ScanError(f"angle_max: got {last:g}, expected {first:g} + {len(ranges) - 1} steps of {step:g}")
    stamp, between = seconds_from_stamp(message.header.stamp), _time_increment(message, step)
    if taken.stamp_offset != 0.0:
        stamp += taken.stamp_offset
    if taken.backwards:
        stamp, between = stamp + between * (len(ranges) - 1), -between
    return Scan(
        stamp=stamp,
        angle_min=first,
        angle_increment=step,
        range_min=float(message.range_min),
        range_max=float(message.range_max),
        ranges=ranges,
        time_increment=between,
    )


def _ranges(message: Any, taken: ScanInput) -> np.ndarray:
    """(n,) the ranges of a LaserScan [m], NaN where they are not to be believed."""
    ranges = np.array(message.ranges, dtype=np.float64)
    if taken.infinite == "lost":
        ranges[ranges == np.inf] = np.nan
    ranges[(ranges >= 0.0) & (ranges <= taken.codes_below)] = ZERO[taken.zero]
    if taken.min_intensity > 0.0:
        intensities = np.array(message.intensities, dtype=np.float64)
        if len(intensities) != len(ranges):
            got = f"got {len(intensities)}, expected {len(ranges)}, as many as ranges"
            raise ScanError(f"intensities: {got}: scan.min_intensity is {taken.min_intensity:g}")
        # a beam that met nothing has no intensity
        ranges[np.isfinite(ranges) & ~(intensities >= taken.min_intensity)] = np.nan
    return ranges


def _time_increment(message: Any, step: float) -> float:
    """Time from beam to beam [s]; of a driver that gives that of a turn alone, the turn's share."""
    between, turn = float(message.time_increment), float(message.scan_time)
    return turn * abs(step) / math.tau if between == 0.0 and turn > 0.0 else between


def plan_from_path(path: Any, frame: str) -> Plan:
    """The plan in a Path: times and positions as sent, velocities differentiated from them, without contacts.

    Raises:
        PathError: another frame, fewer than 2 poses, not finite, or times that do not rise.
    """
    if path.header.frame_id != frame:
        raise PathError(f"header.frame_id: got {path.header.frame_id!r}, expected {frame!r}")
    times = np.array([seconds_from_stamp(pose.header.stamp) for pose in path.poses])
    points = [(float(pose.pose.position.x), float(pose.pose.position.y)) for pose in path.poses]
    return timed_plan(seconds_from_stamp(path.header.stamp), times, np.array(points).reshape(-1, 2))


def timed_plan(stamp: float, times: np.ndarray, positions: np.ndarray) -> Plan:
    """The plan of this stamp [s] that is at positions (n, 2) [m] at times (n,) [s].

    Raises:
        PathError: n under 2, not finite, or times that do not rise.
    """
    check_points(positions)
    if len(times) < 2:
        raise PathError(f"poses: got {len(times)}, expected at least 2")
    for number in np.flatnonzero(np.diff(times) <= 0.0):
        after = f"got time {times[number + 1]} after {times[number]}"
        raise PathError(f"poses[{number + 1}]: {after}, expected a later one")
    velocities = np.gradient(positions, times, axis=0, edge_order=2 if len(times) > 2 else 1)
    return timed_path(stamp, times, positions, velocities)


def check_points(positions: np.ndarray) -> None:
    """Raises PathError where one of a path's positions (n, 2) is not finite."""
    for number in np.flatnonzero(~np.isfinite(positions).all(axis=1)):
        raise PathError(f"poses[{number}]: got {positions[number].tolist()}, expected finite numbers")
