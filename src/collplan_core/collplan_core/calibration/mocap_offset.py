"""The place of the measured body on the robot, from how it turns and how it follows commands."""

from dataclasses import dataclass
from math import hypot, inf

import numpy as np

from collplan_core.calibration.stroke_fit import AxesFit
from collplan_core.calibration.turn_fit import TurnFit
from collplan_core.plane import rotate
from collplan_core.sensing.pose_filter import PoseSample

ENOUGH_POSITION = 1.6e-3
"""Standard deviation by axis of a position that is certain enough: 1 in 1000 is then off by 6 mm [m]."""
ENOUGH_YAW = np.radians(0.5)
"""Standard deviation of a heading that is certain enough: 1 in 1000 is then off by 1.6 degrees [rad]."""


@dataclass(frozen=True)
class BodyOffset:
    """Pose of the measured body on the robot: x forward and y left of its centre [m], heading [rad].

    Attributes:
        position_uncertainty: standard deviation of x and of y [m].
        yaw_uncertainty: standard deviation of yaw [rad].
    """

    x: float
    y: float
    yaw: float
    position_uncertainty: float = inf
    yaw_uncertainty: float = inf


def body_offset(axes: AxesFit, turns: TurnFit) -> BodyOffset:
    """The values of `mocap.body_offset_x`, `_y` and `_yaw`."""
    # a direction of the robot is seen turned back by the body's own heading on it
    yaw = -axes.turn
    x, y = rotate(*turns.lever.tolist(), yaw)
    turned = axes.uncertainty * hypot(x, y)
    return BodyOffset(x, y, yaw, hypot(turns.uncertainty, turned), axes.uncertainty)


def mean_pose(poses: list[PoseSample]) -> PoseSample:
    """Mean position and heading of a body at rest, with the last stamp."""
    yaw = float(np.angle(np.mean(np.exp(1j * np.array([pose.yaw for pose in poses])))))
    return PoseSample(poses[-1].stamp, np.mean([pose.position for pose in poses], axis=0), yaw)
