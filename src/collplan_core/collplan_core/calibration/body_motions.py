"""The motions from which the place of the measured body on the robot is estimated."""

from typing import Protocol

import numpy as np

from collplan_core.calibration.mocap_offset import AxesFit, displacement, fit_axes, fit_lever, mean_pose
from collplan_core.sensing.pose_filter import PoseSample

DISTANCE, SPEED = 0.1, 0.1
"""Distance and speed of a motion along an axis [m, m/s]."""
DIRECTIONS = np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
"""Directions of the motions: each way and back, so that the robot ends where it began."""
MOST_ROUNDS = 3
"""Times the four motions are driven at most."""
ENOUGH_CERTAINTY = np.radians(0.5)
"""Standard deviation of the body's heading above which the motions are repeated [rad]."""
REVOLUTION = 2.1 * np.pi
"""Commanded turn in place: a little more than one revolution [rad]."""


class MeasuredRobot(Protocol):
    """A robot that can be driven open loop while the body on it is measured."""

    def drive(self, velocity: tuple[float, float], yaw_rate: float, duration: float) -> list[PoseSample]:
        """The body's poses while a velocity [m/s, robot frame] and a yaw rate [rad/s] are commanded for `duration` [s].

        The robot is at rest afterwards.
        """

    def rest(self) -> list[PoseSample]:
        """Some poses of the body at rest."""


def turn_in_place(robot: MeasuredRobot, yaw_rate: float) -> tuple[np.ndarray, float]:
    """One turn at `yaw_rate` [rad/s]: lever of `fit_lever` (2,) [m], and the share of the turn that was measured."""
    poses = robot.drive((0.0, 0.0), yaw_rate, REVOLUTION / yaw_rate)
    yaws = np.unwrap([pose.yaw for pose in poses])
    return fit_lever(poses), float(yaws[-1] - yaws[0]) / REVOLUTION


def drive_each_way(robot: MeasuredRobot, lever: np.ndarray, max_speed: float) -> AxesFit:
    """Drives forward, back, left and right, again while the result is uncertain.

    Args:
        lever: (2,) lever found by `turn_in_place` [m].
        max_speed: upper limit of the speed [m/s].
    """
    speed = min(SPEED, max_speed)
    commanded: list[np.ndarray] = []
    measured: list[np.ndarray] = []
    before = mean_pose(robot.rest())
    for _ in range(MOST_ROUNDS):
        for x, y in DIRECTIONS.tolist():
            robot.drive((speed * x, speed * y), 0.0, DISTANCE / speed)
            after = mean_pose(robot.rest())
            commanded.append(DISTANCE * np.array([x, y]))
            measured.append(displacement(before, after, lever))
            before = after
        fit = fit_axes(np.array(commanded), np.array(measured))
        if fit.uncertainty <= ENOUGH_CERTAINTY:
            break
    return fit
