"""Conversion between the project's records and ROS messages: stamps, poses, impacts, scans and commands.

Messages are read in `reading` where their attributes suffice.

Every field is cast to Python's own float, int or str: rclpy does not check fields by default, and then sends garbage
for an int or a numpy scalar in a float field.
"""

import math
from array import array

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Quaternion, Twist, TwistStamped, Vector3, Vector3Stamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from collplan_core.command import Command
from collplan_core.parameters import Control, Settings
from collplan_core.plane import rotate_rows
from collplan_core.poses.pose_filter import EXACT, Deviations, PoseSample
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_ros.messages.reading import NANOSECONDS

UNMEASURED = 1e6
"""Variance of unmeasured fields of an Odometry, which are 0: height, roll and pitch, and their rates; in SI units."""


# ---- stamps, headers, angles


def stamp_from_seconds(seconds: float) -> Time:
    """The stamp nearest to a time [s]; `seconds_from_stamp` gives that time back, to 1 ns below 10 days."""
    whole = math.floor(seconds)
    nanoseconds = round((seconds - whole) * NANOSECONDS)
    return Time(sec=whole + nanoseconds // NANOSECONDS, nanosec=nanoseconds % NANOSECONDS)


def header(stamp: float, frame: str) -> Header:
    """A header with this stamp [s] and frame."""
    return Header(stamp=stamp_from_seconds(stamp), frame_id=str(frame))


def quaternion_from_yaw(yaw: float) -> Quaternion:
    """The quaternion of a rotation about z by `yaw` [rad]."""
    return Quaternion(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))


# ---- poses and states


def pose_to_message(sample: PoseSample, frame: str) -> PoseStamped:
    """Message of a measured pose in `frame`."""
    message = PoseStamped(header=header(sample.stamp, frame))
    message.pose.position.x, message.pose.position.y = (float(v) for v in sample.position)
    message.pose.position.z = float(sample.height)
    message.pose.orientation = _tipped(quaternion_from_yaw(float(sample.yaw)), float(sample.tilt))
    return message


def _tipped(upright: Quaternion, tilt: float) -> Quaternion:
    """A turn about the vertical, after one about the body's x axis by `tilt` [rad]."""
    c, s = math.cos(0.5 * tilt), math.sin(0.5 * tilt)
    return Quaternion(w=c * upright.w, x=s * upright.w, y=s * upright.z, z=c * upright.z)


def goal_to_message(goal: np.ndarray, frame: str, stamp: float = 0.0) -> PoseStamped:
    """Message of a goal (2,) [m] in `frame`; its orientation has no meaning."""
    return pose_to_message(PoseSample(stamp, np.asarray(goal), 0.0), frame)


def state_to_odometry(
    state: State, map_frame: str, base_frame: str, yaw_rate: float = 0.0, deviations: Deviations = EXACT
) -> Odometry:
    """Message of a state and its yaw rate [rad/s]: pose in the map frame, twist in the base frame.

    The covariances are those of these standard deviations; the true state is exact, with variances of 0.
    """
    message = Odometry(header=header(state.stamp, map_frame), child_frame_id=str(base_frame))
    message.pose.pose.position.x, message.pose.pose.position.y = (float(v) for v in state.position)
    message.pose.pose.orientation = quaternion_from_yaw(float(state.yaw))
    message.twist.twist.linear = vector3(rotate_rows(state.velocity[None], -float(state.yaw))[0])
    message.twist.twist.angular.z = float(yaw_rate)
    message.pose.covariance = _covariance(deviations.position, deviations.yaw)
    message.twist.covariance = _covariance(deviations.velocity, deviations.yaw_rate)
    return message


def _covariance(along: float, about: float) -> np.ndarray:
    """(36,), row by row over x, y, z and the turns about them, of deviations along x and y and about z."""
    diagonal = along**2, along**2, UNMEASURED, UNMEASURED, UNMEASURED, about**2
    return np.diag(diagonal).reshape(36)


def impact_to_message(stamp: float, change: np.ndarray, frame: str) -> Vector3Stamped:
    """Message of an impact at `stamp` [s] that changed the velocity by `change` (2,) [m/s, `frame`]."""
    return Vector3Stamped(header=header(stamp, frame), vector=vector3(change))


def vector3(xy: np.ndarray) -> Vector3:
    """Message of a vector (2,) in the plane."""
    return Vector3(x=float(xy[0]), y=float(xy[1]), z=0.0)


# ---- scans


def scan_to_message(scan: Scan, frame: str) -> LaserScan:
    """Message of a scan in the sensor's frame `frame`; scan_time is that of a sweep, 0 where it is one instant."""
    return LaserScan(
        header=header(scan.stamp, frame),
        angle_min=float(scan.angle_min),
        angle_max=float(scan.angle_min + scan.angle_increment * (len(scan.ranges) - 1)),
        angle_increment=float(scan.angle_increment),
        time_increment=float(scan.time_increment),
        scan_time=float(scan.time_increment * len(scan.ranges)),
        range_min=float(scan.range_min),
        range_max=float(scan.range_max),
        ranges=array("f", scan.ranges.astype(np.float32).tobytes()),
    )


# ---- commands


def twist_of(velocity: np.ndarray, yaw_rate: float) -> Twist:
    """Message of a velocity (2,) [m/s] and a yaw rate [rad/s] in the robot's frame."""
    return Twist(linear=vector3(velocity), angular=Vector3(x=0.0, y=0.0, z=float(yaw_rate)))


def command_to_twist(command: Command) -> Twist:
    """Message of a command in the robot's frame."""
    return twist_of(command.velocity, command.yaw_rate)


def asks_for_rest(twist: Twist) -> bool:
    """Returns whether a twist commands zero velocity and yaw rate."""
    return bool(twist.linear.x == twist.linear.y == twist.angular.z == 0.0)


def command_type(controller: Control) -> type[Twist] | type[TwistStamped]:
    """The message type of cmd_vel."""
    return TwistStamped if controller.stamped_cmd_vel else Twist


def command_to_message(command: Command, stamp: float, settings: Settings) -> Twist | TwistStamped:
    """A command as a message for cmd_vel; a TwistStamped carries the stamp [s, poses' clock]."""
    twist = command_to_twist(command)
    if settings.controller.stamped_cmd_vel:
        return TwistStamped(header=header(stamp, settings.frames.base), twist=twist)
    return twist
