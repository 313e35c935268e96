"""The place of the measured body on the robot, from how it turns and how it follows commands."""

from dataclasses import dataclass
from math import hypot, inf

from collplan_core.calibration.stroke_fit import AxesFit
from collplan_core.calibration.turn_fit import TurnFit
from collplan_core.plane import rotate


@dataclass(frozen=True)
class BodyOffset:
    """Pose of the measured body on the robot: x forward and y left of its centre [m], heading [rad]."""

    x: float
    y: float
    yaw: float
    position_uncertainty: float = inf  # standard deviation of x and of y [m]
    yaw_uncertainty: float = inf  # standard deviation of yaw [rad]


def body_offset(axes: AxesFit, turns: TurnFit) -> BodyOffset:
    """The values of `mocap.body_offset_x`, `_y` and `_yaw`."""
    # a direction of the robot is seen turned back by the body's own heading on it
    yaw = -axes.turn
    x, y = rotate(*turns.lever.tolist(), yaw)
    turned = axes.uncertainty * hypot(x, y)
    return BodyOffset(x, y, yaw, hypot(turns.uncertainty, turned), axes.uncertainty)
