"""Checks of received velocity commands, shared by the simulated and the real robot."""

import numpy as np
from geometry_msgs.msg import Twist

from collplan_core.control.tracking import clip_command
from collplan_core.parameters import Limits, Robot
from collplan_ros.messages.conversions import MessageError, velocity_from_twist

REFUSED = "last command refused: not finite or too fast"
"""Health message of a robot whose last command was refused."""


class CommandCheck:
    """Clips commands to the robot's limits, refuses those not finite or far beyond the limits, and counts both.

    Attributes:
        last_refused: whether the last command was refused.
    """

    def __init__(self, robot: Robot, limits: Limits) -> None:
        """Starts with both counts at zero."""
        self._robot = robot
        self._limits = limits
        self._clipped = self._refused = 0
        self.last_refused = False

    def followed(self, twist: Twist) -> tuple[np.ndarray, float]:
        """Velocity (2,) [m/s, robot frame] and yaw rate [rad/s] to follow: the command clipped, or zero if refused."""
        try:
            velocity, yaw_rate = velocity_from_twist(twist)
            accepted = clip_command(velocity, yaw_rate, self._robot, self._limits)
        except MessageError:
            accepted = None
        self.last_refused = accepted is None
        if accepted is None:
            self._refused += 1
            return np.zeros(2), 0.0
        self._clipped += not np.array_equal(accepted[0], velocity)
        return accepted

    @property
    def counts(self) -> dict[str, int]:
        """Clipped and refused commands so far, as values of a `Health`."""
        return {"clipped": self._clipped, "refused": self._refused}
