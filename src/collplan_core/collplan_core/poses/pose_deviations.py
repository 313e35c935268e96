"""Standard deviations of position, velocity and yaw rate estimated from poses."""

import math
from typing import NamedTuple

from collplan_core.parameters import Mocap, Robot
from collplan_core.poses.impact_detection import ACCELERATION_SHARE
from collplan_core.poses.pose_track import FittedMotion


class Deviations(NamedTuple):
    """Standard deviations of a measured motion."""

    position: float  # by axis [m]
    yaw: float  # [rad]
    velocity: float  # by axis [m/s]
    yaw_rate: float  # [rad/s]


EXACT = Deviations(0.0, 0.0, 0.0, 0.0)


def deviations_of(motion: FittedMotion, robot: Robot, mocap: Mocap) -> Deviations:
    """Standard deviations of the newest pose and of the slopes up to it, taken for those at its stamp.

    Meanwhile the wheels may have changed the velocity, and that of a turning rim by as much.
    """
    changed = ACCELERATION_SHARE * robot.max_acceleration * motion.delay
    steepness = 1.0 / math.sqrt(motion.spread)
    return Deviations(
        mocap.position_noise,
        mocap.yaw_noise,
        math.hypot(mocap.position_noise * steepness, changed),
        math.hypot(mocap.yaw_noise * steepness, changed / robot.radius),
    )
