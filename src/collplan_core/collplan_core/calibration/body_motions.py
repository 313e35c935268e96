"""The motions that show where the measured body sits on the robot, and what they show."""

from typing import Protocol

import numpy as np

from collplan_core.calibration.mocap_offset import AxesFit, displacement, fit_axes, fit_lever, mean_pose
from collplan_core.sensing.pose_filter import PoseSample

DISTANCE, SPEED = 0.1, 0.1
"""Of a motion along an axis [m, m/s]."""
DIRECTIONS = np.array([(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
"""Each way and back, so that the robot ends where it began."""
MOST_ROUNDS = 3
ENOUGH_CERTAINTY = np.radians(0.5)
"""Of the body's heading; beyond it the motions are repeated [rad]."""
REVOLUTION = 2.1 * np.pi
"""A little more than one [rad]."""


class Driver(Protocol):
    """Something that moves a robot and sees a body on it."""

    def drive(self, velocity: tuple[float, float], yaw_rate: float, duration: float) -> list[PoseSample]:
        """The body's poses while a velocity [m/s, robot frame] and a yaw rate [rad/s] are commanded; ends at rest."""

    def rest(self) -> list[PoseSample]:
        """Some poses of the body at rest."""


def turn_in_place(driver: Driver, yaw_rate: float) -> tuple[np.ndarray, float]:
    """The lever of `fit_lever` (2,) [m], and the share of the commanded turn that was measured."""
    poses = driver.drive((0.0, 0.0), yaw_rate, REVOLUTION / yaw_rate)
    yaws = np.unwrap([pose.yaw for pose in poses])
    return fit_lever(poses), float(yaws[-1] - yaws[0]) / REVOLUTION


def drive_each_way(driver: Driver, lever: np.ndarray, max_speed: float) -> AxesFit:
    """Forward, back, left and back, again while the result is uncertain."""
    speed = min(SPEED, max_speed)
    commanded: list[np.ndarray] = []
    measured: list[np.ndarray] = []
    before = mean_pose(driver.rest())
    for _ in range(MOST_ROUNDS):
        for x, y in DIRECTIONS.tolist():
            driver.drive((speed * x, speed * y), 0.0, DISTANCE / speed)
            after = mean_pose(driver.rest())
            commanded.append(DISTANCE * np.array([x, y]))
            measured.append(displacement(before, after, lever))
            before = after
        fit = fit_axes(np.array(commanded), np.array(measured))
        if fit.uncertainty <= ENOUGH_CERTAINTY:
            break
    return fit
