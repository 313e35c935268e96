"""Conversion between the project's records and ROS messages: the only place where message fields are filled and read.

The exception are the poses of a motion-capture system, which `mocap_formats` reads.

Every field is cast to Python's own float, int or str: rclpy does not check fields by default, and then sends garbage
for an int or a numpy scalar in a float field.
"""

import math
from array import array

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Quaternion, Twist, TwistStamped, Vector3, Vector3Stamped
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from collplan_core.command import Command
from collplan_core.plan import Candidates, Contacts, Plan
from collplan_core.plane import rotate_rows
from collplan_core.scan import Scan, ScanError
from collplan_core.sensing.pose_filter import PoseSample
from collplan_core.state import State

NANOSECONDS = 1_000_000_000
QUATERNION_TOLERANCE = 0.01
"""Largest deviation of a quaternion's norm from 1 in the project's own messages."""


class MessageError(ValueError):
    """A message that cannot be used; the text names the field, the value and what was expected."""


class PathError(MessageError):
    """A path that holds no usable plan or foreseen contacts."""


# ---- stamps, headers, angles


def stamp_from_seconds(seconds: float) -> Time:
    """The stamp nearest to a time [s]; `seconds_from_stamp` gives that time back, to 1 ns below 10 days."""
    whole = math.floor(seconds)
    nanoseconds = round((seconds - whole) * NANOSECONDS)
    return Time(sec=whole + nanoseconds // NANOSECONDS, nanosec=nanoseconds % NANOSECONDS)


def seconds_from_stamp(stamp: Time) -> float:
    """The time of a stamp [s]: exact to the nanosecond below 100 days, to 0.2 us in Unix time."""
    return int(stamp.sec) + int(stamp.nanosec) / NANOSECONDS


def header(stamp: float, frame: str) -> Header:
    """A header with this stamp [s] and frame."""
    return Header(stamp=stamp_from_seconds(stamp), frame_id=str(frame))


def quaternion_from_yaw(yaw: float) -> Quaternion:
    """The quaternion of a rotation about z by `yaw` [rad]."""
    return Quaternion(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))


def yaw_from_quaternion(quaternion: Quaternion) -> float:
    """The yaw of a quaternion, in [-pi, pi] [rad].

    Raises:
        MessageError: not finite, or not a unit quaternion.
    """
    x, y, z, w = (float(v) for v in (quaternion.x, quaternion.y, quaternion.z, quaternion.w))
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(norm - 1.0) <= QUATERNION_TOLERANCE:
        raise MessageError(f"orientation: got ({x:g}, {y:g}, {z:g}, {w:g}), expected a quaternion of length 1")
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def _check_frame(field: str, got: str, expected: str) -> None:
    if got != expected:
        raise MessageError(f"{field}: got frame {got!r}, expected {expected!r}")


def _check_finite(field: str, *values: float) -> None:
    if not all(math.isfinite(value) for value in values):
        raise MessageError(f"{field}: got {', '.join(f'{v:g}' for v in values)}, expected finite numbers")


# ---- poses and states


def pose_to_message(sample: PoseSample, frame: str) -> PoseStamped:
    """Message of a measured pose in `frame`."""
    message = PoseStamped(header=header(sample.stamp, frame))
    message.pose.position.x, message.pose.position.y = (float(v) for v in sample.position)
    message.pose.orientation = quaternion_from_yaw(float(sample.yaw))
    return message


def goal_to_message(goal: np.ndarray, frame: str, stamp: float = 0.0) -> PoseStamped:
    """Message of a goal (2,) [m] in `frame`; its orientation has no meaning."""
    return pose_to_message(PoseSample(stamp, np.asarray(goal), 0.0), frame)


def goal_from_message(message: PoseStamped, frame: str) -> np.ndarray:
    """The goal (2,) [m, `frame`] in a message.

    Raises:
        MessageError: another frame, or not finite.
    """
    _check_frame("header.frame_id", message.header.frame_id, frame)
    x, y = float(message.pose.position.x), float(message.pose.position.y)
    _check_finite("pose.position", x, y)
    return np.array([x, y])


def state_to_odometry(state: State, map_frame: str, base_frame: str) -> Odometry:
    """Message of a state: pose in the map frame, twist in the base frame."""
    message = Odometry(header=header(state.stamp, map_frame), child_frame_id=str(base_frame))
    message.pose.pose.position.x, message.pose.pose.position.y = (float(v) for v in state.position)
    message.pose.pose.orientation = quaternion_from_yaw(float(state.yaw))
    message.twist.twist.linear = _vector(rotate_rows(state.velocity[None], -float(state.yaw))[0])
    return message


def state_from_odometry(message: Odometry, map_frame: str, base_frame: str) -> State:
    """The state in a message, in the map frame.

    Raises:
        MessageError: other frames, not finite, or not a unit quaternion.
    """
    _check_frame("header.frame_id", message.header.frame_id, map_frame)
    _check_frame("child_frame_id", message.child_frame_id, base_frame)
    p, v = message.pose.pose.position, message.twist.twist.linear
    position, velocity = np.array([float(p.x), float(p.y)]), np.array([float(v.x), float(v.y)])
    _check_finite("pose.position", *position)
    _check_finite("twist.linear", *velocity)
    yaw = yaw_from_quaternion(message.pose.pose.orientation)
    return State(seconds_from_stamp(message.header.stamp), position, rotate_rows(velocity[None], yaw)[0], yaw)


def impact_to_message(stamp: float, change: np.ndarray, frame: str) -> Vector3Stamped:
    """Message of an impact at `stamp` [s] that changed the velocity by `change` (2,) [m/s, `frame`]."""
    return Vector3Stamped(header=header(stamp, frame), vector=_vector(change))


def impact_from_message(message: Vector3Stamped, frame: str) -> tuple[float, np.ndarray]:
    """The stamp [s] and the change of velocity (2,) [m/s, `frame`] of an impact in a message.

    Raises:
        MessageError: another frame, or not finite.
    """
    _check_frame("header.frame_id", message.header.frame_id, frame)
    x, y = float(message.vector.x), float(message.vector.y)
    _check_finite("vector", x, y)
    return seconds_from_stamp(message.header.stamp), np.array([x, y])


def _vector(xy: np.ndarray) -> Vector3:
    return Vector3(x=float(xy[0]), y=float(xy[1]), z=0.0)


# ---- scans


def scan_to_message(scan: Scan, frame: str) -> LaserScan:
    """Message of a scan in the robot's frame `frame`; all beams are of one instant."""
    return LaserScan(
        header=header(scan.stamp, frame),
        angle_min=float(scan.angle_min),
        angle_max=float(scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)),
        angle_increment=float(scan.angle_increment),
        range_min=float(scan.range_min),
        range_max=float(scan.range_max),
        ranges=array("f", scan.ranges.astype(np.float32).tobytes()),
    )


def scan_from_message(message: LaserScan, frame: str) -> Scan:
    """The scan in a message, in the robot's frame `frame`.

    Raises:
        ScanError: another frame, angles that do not fit the number of ranges, or values that `Scan` refuses.
    """
    if message.header.frame_id != frame:
        raise ScanError(f"header.frame_id: got {message.header.frame_id!r}, expected {frame!r}")
    first, last, step = float(message.angle_min), float(message.angle_max), float(message.angle_increment)
    ranges = np.array(message.ranges, dtype=np.float64)
    # devices disagree on whether angle_max is the last beam's angle or one step further
    if not abs(first + step * (len(ranges) - 1) - last) <= 1.5 * abs(step):
        raise ScanError(f"angle_max: got {last:g}, expected {first:g} + {len(ranges) - 1} steps of {step:g}")
    return Scan(
        stamp=seconds_from_stamp(message.header.stamp),
        angle_min=first,
        angle_increment=step,
        range_min=float(message.range_min),
        range_max=float(message.range_max),
        ranges=ranges,
    )


# ---- plans and foreseen contacts


def plan_to_path(plan: Plan, frame: str) -> Path:
    """Path of a plan's timed positions: its stamp is the plan's, the stamp of each pose the time to be there."""
    return _path(plan.stamp, plan.times, plan.positions, np.zeros(len(plan.times)), frame)


def plan_from_path(path: Path, frame: str, contacts: Contacts | None = None) -> Plan:
    """The plan in a path: times and positions as sent, velocities differentiated from them.

    Raises:
        PathError: another frame, fewer than 2 poses, not finite, or times that do not rise.
    """
    times, positions = _timed_positions(path, frame)
    if len(times) < 2:
        raise PathError(f"poses: got {len(times)}, expected at least 2")
    velocities = np.gradient(positions, times, axis=0, edge_order=2 if len(times) > 2 else 1)
    nothing = Candidates(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    return Plan(
        stamp=seconds_from_stamp(path.header.stamp),
        times=times,
        positions=positions,
        velocities=velocities,
        contacts=Contacts.none() if contacts is None else contacts,
        aim=positions[-1],
        aim_velocity=velocities[-1],
        terms={},
        candidates=nothing,
        n_before_pruning=0,
    )


def contacts_to_path(contacts: Contacts, stamp: float, frame: str) -> Path:
    """Path of the contacts foreseen by the plan with this stamp [s]; each orientation is the direction afterwards."""
    directions = np.arctan2(contacts.velocities_after[:, 1], contacts.velocities_after[:, 0])
    return _path(stamp, contacts.times, contacts.points, directions, frame)


def contacts_from_path(path: Path, frame: str) -> Contacts:
    """The foreseen contacts in a path, possibly none; the velocities after them have length 1, for want of speeds.

    Raises:
        PathError: another frame, not finite, times that do not rise, or a quaternion without length 1.
    """
    times, points = _timed_positions(path, frame)
    try:
        directions = np.array([yaw_from_quaternion(pose.pose.orientation) for pose in path.poses])
    except MessageError as error:
        raise PathError(f"poses: {error}") from error
    return Contacts(times, points, np.column_stack([np.cos(directions), np.sin(directions)]).reshape(-1, 2))


def _path(stamp: float, times: np.ndarray, positions: np.ndarray, directions: np.ndarray, frame: str) -> Path:
    poses = [
        pose_to_message(PoseSample(float(time), position, float(direction)), frame)
        for time, position, direction in zip(times, positions, directions, strict=True)
    ]
    return Path(header=header(stamp, frame), poses=poses)


def _timed_positions(path: Path, frame: str) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) [s] and positions (n, 2) [m] of a path's poses."""
    if path.header.frame_id != frame:
        raise PathError(f"header.frame_id: got {path.header.frame_id!r}, expected {frame!r}")
    times = np.array([seconds_from_stamp(pose.header.stamp) for pose in path.poses])
    points = [(float(pose.pose.position.x), float(pose.pose.position.y)) for pose in path.poses]
    positions = np.array(points).reshape(-1, 2)
    for number in np.flatnonzero(~np.isfinite(positions).all(axis=1)):
        raise PathError(f"poses[{number}]: got {positions[number].tolist()}, expected finite numbers")
    for number in np.flatnonzero(np.diff(times) <= 0.0):
        after = f"got time {times[number + 1]} after {times[number]}"
        raise PathError(f"poses[{number + 1}]: {after}, expected a later one")
    return times, positions


# ---- commands


def command_to_twist(command: Command) -> Twist:
    """Message of a command in the robot's frame."""
    return Twist(linear=_vector(command.velocity), angular=Vector3(x=0.0, y=0.0, z=float(command.yaw_rate)))


def command_to_twist_stamped(command: Command, stamp: float, frame: str) -> TwistStamped:
    """Message of a command in the robot's frame `frame`, with a stamp [s]."""
    return TwistStamped(header=header(stamp, frame), twist=command_to_twist(command))


def asks_for_rest(twist: Twist) -> bool:
    """Whether a twist commands zero velocity and yaw rate."""
    return bool(twist.linear.x == twist.linear.y == twist.angular.z == 0.0)


def velocity_from_twist(twist: Twist) -> tuple[np.ndarray, float]:
    """The velocity (2,) [m/s, robot frame] and the yaw rate [rad/s] that a twist commands.

    Raises:
        MessageError: not finite.
    """
    x, y, yaw_rate = float(twist.linear.x), float(twist.linear.y), float(twist.angular.z)
    _check_finite("twist", x, y, yaw_rate)
    return np.array([x, y]), yaw_rate
