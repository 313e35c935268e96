"""Reads messages by their attributes alone.

A message decoded from a recording will do as well as one of rclpy's, and no ROS is needed.
"""

import math
from typing import Any

import numpy as np

from collplan_core.goal import ABORTED, ACCEPTED, CANCELED, EXECUTING, NO_GOAL, SUCCEEDED
from collplan_core.parameters import ScanInput
from collplan_core.scan import ROUNDED, Scan, ScanError
from collplan_core.scans.filters import in_time, is_masked

NANOSECONDS = 1_000_000_000
SHIPPED = ScanInput()
QUATERNION_TOLERANCE = 0.01
"""Largest deviation of a quaternion's norm from 1 in the project's own messages."""
GOAL_STATUS = {0: NO_GOAL, 1: ACCEPTED, 2: EXECUTING, 4: SUCCEEDED, 5: CANCELED, 6: ABORTED}
"""Status of a goal by its number in action_msgs/GoalStatus."""
MANY_NEAR = 0.1
"""Share of ranges below range_min that is suspicious: something may be near, or a number means something else."""
ZERO = {"near": 0.0, "lost": math.nan, "free": math.inf}
"""Replacement for a range of 0; a near one stays, as it is below range_min."""
ARROW, CYLINDER = 0, 3
"""Types of a visualization_msgs/Marker: a mover is a cylinder, and an arrow of the same id where it moves."""
AHEAD = 0.5
"""An arrow leads to where the mover would be after so long [s]."""


class MessageError(ValueError):
    """A message that cannot be used; the text names the field, the value and what was expected."""


def seconds_from_stamp(stamp: Any) -> float:
    """The time of a Time, or a Duration [s]: exact to the nanosecond below 100 days, to 0.2 us in Unix time."""
    return int(stamp.sec) + int(stamp.nanosec) / NANOSECONDS


def place_fields(
    position: Any, quaternion: Any
) -> tuple[tuple[float, float, float], tuple[float, float, float, float]]:
    """The numbers x, y, z of a position or translation, and x, y, z, w of a quaternion."""
    return (
        (float(position.x), float(position.y), float(position.z)),
        (float(quaternion.x), float(quaternion.y), float(quaternion.z), float(quaternion.w)),
    )


def check_frame(field: str, got: str, expected: str) -> None:
    """Raises MessageError where a field names another frame."""
    if got != expected:
        raise MessageError(f"{field}: got frame {got!r}, expected {expected!r}")


def check_finite(field: str, *values: float) -> None:
    """Raises MessageError where a value is not finite."""
    if not all(math.isfinite(value) for value in values):
        raise MessageError(f"{field}: got {', '.join(f'{v:g}' for v in values)}, expected finite numbers")


def scan_from_message(message: Any, frame: str, taken: ScanInput = SHIPPED) -> Scan:
    """The scan in a LaserScan, in the sensor's frame, without the sensor's place on the robot.

    ScanError: a frame other than the robot's `frame` unless `taken.frame` is set, angles that do not fit the number of
    ranges, or values that `Scan` refuses.
    """
    expected = taken.frame or frame
    if message.header.frame_id != expected:
        key = "scan.frame" if taken.frame else "frames.base, where scan.frame is empty"
        raise ScanError(f"header.frame_id: got {message.header.frame_id!r}, expected {expected!r} ({key})")
    first, last, step = float(message.angle_min), float(message.angle_max), float(message.angle_increment)
    ranges = _ranges(message, taken)
    if len(ranges) == 0:
        raise ScanError("ranges: got none, expected at least 2")
    # devices disagree on whether angle_max is the last beam's angle or one step further, and on rounding their number
    if not abs(first + step * (len(ranges) - 1) - last) <= 2.01 * abs(step):
        raise ScanError(f"angle_max: got {last:g}, expected {first:g} + {len(ranges) - 1} steps of {step:g}")
    scan = Scan(
        stamp=seconds_from_stamp(message.header.stamp),
        angle_min=first,
        angle_increment=step,
        range_min=float(message.range_min),
        range_max=float(message.range_max),
        ranges=ranges,
        time_increment=0.0 if taken.instant else _time_increment(message, step),
    )
    return in_time(scan, taken)


def suspiciously_near(message: Any, taken: ScanInput) -> str:
    """Returns what is suspicious about the ranges below range_min in a LaserScan; "" where they are few."""
    measured, floor = np.asarray(message.ranges), max(message.range_min, taken.codes_below)
    if not ((measured >= 0.0) & (measured <= floor)).any():  # as of nearly every scan: nothing is read again
        return ""
    ranges = _ranges(message, taken)
    angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
    used = ranges[~is_masked(angles, taken.masked_angles)]
    near = (used >= 0.0) & ((used < message.range_min) | (used == 0.0))
    share = near.sum() / max(len(used), 1)
    found = f"{share:.0%} of the beams are nearer than range_min: scan.zero, scan.codes_below?"
    return found if share >= MANY_NEAR else ""


def _ranges(message: Any, taken: ScanInput) -> np.ndarray:
    """(n,) the ranges of a LaserScan [m], NaN where they are invalid."""
    ranges = np.array(message.ranges, dtype=np.float64)
    if taken.infinite == "lost":
        ranges[(ranges == np.inf) | np.isclose(ranges, message.range_max, ROUNDED, 0.0)] = np.nan
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
    if between != 0.0:
        return between
    if not 0.0 <= turn < math.inf:
        raise ScanError(f"scan_time: got {turn:g}, expected a time of at least 0 s, or scan.instant")
    return turn * abs(step) / math.tau


def yaw_of(x: float, y: float, z: float, w: float) -> float:
    """The yaw of a quaternion, in [-pi, pi] [rad]; MessageError: not finite, or not a unit quaternion."""
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(norm - 1.0) <= QUATERNION_TOLERANCE:
        raise MessageError(f"orientation: got ({x:g}, {y:g}, {z:g}, {w:g}), expected a quaternion of length 1")
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def goal_from_message(message: Any, frame: str) -> np.ndarray:
    """The goal (2,) [m, `frame`] in a message; MessageError: another frame, or not finite."""
    check_frame("header.frame_id", message.header.frame_id, frame)
    x, y = float(message.pose.position.x), float(message.pose.position.y)
    check_finite("pose.position", x, y)
    return np.array([x, y])


def impact_from_message(message: Any, frame: str) -> tuple[float, np.ndarray]:
    """The stamp [s] and the change of velocity (2,) [m/s, `frame`] of an impact in a message.

    MessageError: another frame, or not finite.
    """
    check_frame("header.frame_id", message.header.frame_id, frame)
    x, y = float(message.vector.x), float(message.vector.y)
    check_finite("vector", x, y)
    return seconds_from_stamp(message.header.stamp), np.array([x, y])


def velocity_from_twist(twist: Any) -> tuple[np.ndarray, float]:
    """The velocity (2,) [m/s, robot frame] and yaw rate [rad/s] that a twist commands; MessageError: not finite."""
    x, y, yaw_rate = float(twist.linear.x), float(twist.linear.y), float(twist.angular.z)
    check_finite("twist", x, y, yaw_rate)
    return np.array([x, y]), yaw_rate


def twist_of(message: Any) -> Any:
    """The twist in a message of cmd_vel: a Twist, or the one in a TwistStamped."""
    return getattr(message, "twist", message)


def movers_from_markers(message: Any, frame: str) -> tuple[float, np.ndarray]:
    """Stamp [s] and movers (k, 5) x, y [m], vx, vy [m/s], radius [m] of a MarkerArray.

    MessageError: no marker, another frame, or a number that is not finite.
    """
    if not message.markers:
        raise MessageError("markers: got none, expected one that deletes the last ones, and one for each mover")
    rows: dict[int, list[float]] = {}
    for marker in message.markers:
        check_frame("markers.header.frame_id", marker.header.frame_id, frame)
        if marker.type == CYLINDER and marker.action == 0:
            place = marker.pose.position
            rows[marker.id] = [place.x, place.y, 0.0, 0.0, marker.scale.x / 2]
    for marker in message.markers:
        if marker.type == ARROW and marker.id in rows and len(marker.points) == 2:
            (tail, tip), row = marker.points, rows[marker.id]
            row[2:4] = (tip.x - tail.x) / AHEAD, (tip.y - tail.y) / AHEAD
    for row in rows.values():
        check_finite("markers", *row)
    return seconds_from_stamp(message.markers[0].header.stamp), np.array(list(rows.values())).reshape(-1, 5)
