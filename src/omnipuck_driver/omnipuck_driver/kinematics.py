"""Body twist to wheel speeds and back, for n omni wheels, and the rate at which their commands are sent."""

from dataclasses import replace

import numpy as np

from collplan_core.parameters import Cap, Driver, Kinematics, Limits, Robot
from collplan_core.parameters.spec import ParameterError
from omnipuck_driver.codec import Encoder
from omnipuck_driver.messages import MOST_WHEELS, CommandMessage, WheelCaps

FEWEST_WHEELS = 3
SMALLEST_RATIO = 0.05
"""Smallest strength of the weakest direction of motion over the strongest, turning measured at the mount radius."""


class OmniWheels:
    """The wheels of one robot.

    ParameterError: too few or too many wheels, or all of them (nearly) parallel: some motion is then impossible.
    """

    def __init__(self, kinematics: Kinematics) -> None:
        angles = np.array(kinematics.wheel_angles)
        if not FEWEST_WHEELS <= len(angles) <= MOST_WHEELS:
            raise ParameterError(
                f"kinematics.wheel_angles: got {len(angles)} angles, expected {FEWEST_WHEELS} to {MOST_WHEELS}"
            )
        directions = np.column_stack([-np.sin(angles), np.cos(angles), np.ones(len(angles))])
        strengths = np.linalg.svd(directions, compute_uv=False)
        if strengths[-1] < SMALLEST_RATIO * strengths[0]:
            raise ParameterError(
                f"kinematics.wheel_angles: got {angles.tolist()}, all wheels nearly parallel or at one place, expected "
                "angles [rad] spread so that the robot can go and turn every way"
            )
        scale = np.array([1.0, 1.0, kinematics.mount_radius])
        self._to_wheels = directions * scale / kinematics.wheel_radius
        self._to_body = np.linalg.pinv(self._to_wheels)
        self._fastest = kinematics.max_wheel_speed
        self._mount_radius, self._wheel_radius = kinematics.mount_radius, kinematics.wheel_radius

    def __len__(self) -> int:
        return len(self._to_wheels)

    def speeds(self, velocity: np.ndarray, yaw_rate: float) -> np.ndarray:
        """Wheel speeds (n,) [rad/s] of a velocity (2,) [m/s, body frame] and a yaw rate [rad/s]."""
        return self._to_wheels @ np.array([velocity[0], velocity[1], yaw_rate])

    def twist(self, speeds: np.ndarray) -> tuple[np.ndarray, float]:
        """Velocity (2,) [m/s, body frame] and yaw rate [rad/s] nearest to wheel speeds (n,) [rad/s]."""
        x, y, yaw_rate = self._to_body @ speeds
        return np.array([x, y]), float(yaw_rate)

    def caps(self, cap: Cap, robot: Robot) -> WheelCaps:
        """Returns the hard limits of a wheel that follow from the robot's caps and max_yaw_rate."""
        fastest = replace(robot, max_speed=cap.speed).fastest
        speed = min(self._fastest, (fastest + self._mount_radius * robot.max_yaw_rate) / self._wheel_radius)
        return WheelCaps(float(np.float32(speed)), float(np.float32(cap.acceleration / self._wheel_radius)))

    def saturated(self, speeds: np.ndarray) -> np.ndarray:
        """Wheel speeds (n,) slowed so that none is beyond max_wheel_speed; direction and curvature are kept."""
        peak = float(np.max(np.abs(speeds)))
        return speeds if peak <= self._fastest else speeds * (self._fastest / peak)


BITS_PER_BYTE = 10
"""On the line: a start bit, 8 of data, a stop bit."""
FEWEST = 2
"""Commands sent within limits.command_age: one may be lost, and the wheels turn on."""


def check_command_rate(driver: Driver, limits: Limits, n_wheels: int) -> None:
    """Checks that commands of so many wheels come before the last one is too old, and that the line carries them all.

    ParameterError: driver.rate is too low for limits.command_age, or too high for driver.baud.
    """
    least = FEWEST / limits.command_age
    if driver.rate < least:
        raise ParameterError(
            f"driver.rate: got {driver.rate:g}, expected at least {FEWEST} / limits.command_age = {least:.4g} Hz"
        )
    length = len(Encoder().encode(CommandMessage(0, 0, 0, 0, 0, 0, 0, (0.0,) * n_wheels)))
    most = driver.baud / BITS_PER_BYTE / length
    if driver.rate > most:
        raise ParameterError(
            f"driver.rate: got {driver.rate:g}, expected at most {int(most)} Hz: "
            f"driver.baud {driver.baud} carries no more frames of {length} bytes"
        )
