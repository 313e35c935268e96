"""The robot's pose from that of a body of markers, as a motion capture measures it in its own units and axes."""

import math
from dataclasses import dataclass, replace

import numpy as np

from collplan_core.parameters import Mocap
from collplan_core.plane import rotate
from collplan_core.poses.pose_filter import PoseSample, check_pose_fields

EARLY, LATE = 0.3, 0.02
"""Share of a pose's deviation by which the even stamps follow it: a pose may wait on its way, but is never early."""
LOST = 0.5
"""After such a deviation the stamps begin anew [s]."""


def even_stamp(last: float, received: float, period: float) -> float:
    """Returns the stamp [s] of a pose that was received at a time [s], one period [s] after the stamp `last`."""
    expected = last + period
    deviation = received - expected
    if not abs(deviation) <= LOST:
        return received
    return expected + (EARLY if deviation < 0.0 else LATE) * deviation


METRES = {"m": 1.0, "mm": 0.001}


@dataclass(frozen=True)
class MeasuredPose:
    """A body as a receiver reports it, unchecked, in the motion capture's units and axes."""

    frame: str | None  # name of its coordinate frame, None where it has none
    stamp: float | None  # [s]; None where it has none
    position: tuple[float, float, float]  # x, y, z
    quaternion: tuple[float, float, float, float]  # x, y, z, w

    def repeats(self, other: "MeasuredPose | None") -> bool:
        """Returns whether it equals the other to the last bit, as from a motion capture that holds its last value."""
        return other is not None and (self.position, self.quaternion) == (other.position, other.quaternion)


def robot_pose(measured: MeasuredPose, received: float, mocap: Mocap) -> PoseSample:
    """The robot's centre and heading, in metres, z up; stamped with `received` [s] where the measurement has no stamp.

    Its height is that above a floor as of `mocap.floor_tilt`.

    Raises:
        PoseError: no pose; see `check_pose_fields`.
    """
    position, quaternion = measured.position, measured.quaternion
    if mocap.axes == "y_up":
        position, quaternion = _z_up(position), (*_z_up(quaternion[:3]), quaternion[3])
    scaled = tuple(METRES[mocap.units] * value for value in position)
    stamp = received if measured.stamp is None else measured.stamp
    body = check_pose_fields(stamp, scaled, quaternion, mocap.quaternion_tolerance)
    (x, y), (along_x, along_y) = body.position.tolist(), mocap.floor_tilt
    body = replace(body, height=body.height - x * math.tan(along_x) - y * math.tan(along_y))
    return without_offset(body, mocap.body_offset_x, mocap.body_offset_y, mocap.body_offset_yaw)


def _z_up(vector: tuple[float, ...]) -> tuple[float, float, float]:
    """A quarter turn about x; on the vector part of a quaternion it turns the body's own axes too."""
    x, y, z = vector
    return x, -z, y


def with_offset(robot: PoseSample, x: float, y: float, yaw: float) -> PoseSample:
    """The pose of a body that sits at x, y [m], turned by `yaw` [rad], on a robot with this pose."""
    position = robot.position + rotate(x, y, robot.yaw)
    return PoseSample(robot.stamp, position, _wrapped(robot.yaw + yaw), robot.height, robot.tilt)


def on_tilted_floor(level: PoseSample, along_x: float, along_y: float) -> PoseSample:
    """A pose on a level floor as axes show it in which the floor has slopes along x and y [rad], not both 0."""
    rises = np.tan((along_x, along_y))
    steepest, uphill = math.atan(np.hypot(*rises)), rises / np.hypot(*rises)

    def seen_from_above(vector: np.ndarray) -> np.ndarray:
        return vector - (1.0 - math.cos(steepest)) * (vector @ uphill) * uphill

    ahead = seen_from_above(np.array([math.cos(level.yaw), math.sin(level.yaw)]))
    return PoseSample(
        level.stamp,
        seen_from_above(level.position),
        math.atan2(ahead[1], ahead[0]),
        level.height + math.sin(steepest) * float(level.position @ uphill),
        steepest,
    )


def without_offset(body: PoseSample, x: float, y: float, yaw: float) -> PoseSample:
    """The pose of the robot on which a body with this pose sits at x, y [m], turned by `yaw` [rad]."""
    heading = _wrapped(body.yaw - yaw)
    return replace(body, position=body.position - np.array(rotate(x, y, heading)), yaw=heading)


def _wrapped(angle: float) -> float:
    return math.remainder(angle, math.tau)
