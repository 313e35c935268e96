"""Checks and limits of the commands that a robot follows."""

import math
from dataclasses import replace

import numpy as np
from geometry_msgs.msg import Twist

from collplan_core.control.follow import clip_command, cut_to_bounds, saturate
from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError
from collplan_core.velocity_bounds import velocity_bounds
from collplan_ros.messages.reading import MessageError, velocity_from_twist

LIVE = ("robot.max_speed",)
"""The parameters of a robot's node that may change while it runs."""


def check_caps(settings: Settings) -> None:
    """Checks that the speed commanded at most is within the cap; ParameterError otherwise."""
    speed, cap = settings.robot.max_speed, settings.cap.speed
    if speed > cap:
        raise ParameterError(f"robot.max_speed: got {speed:g}, expected at most cap.speed, {cap:g} m/s")


REFUSED = "last command refused: not finite or too fast"
"""Health message of a robot whose last command was refused."""


class CommandCheck:
    """Clamps commands to the limits of `robot` and `cap`, refuses those not finite or far beyond, and counts both."""

    def __init__(self, settings: Settings) -> None:
        """Starts at rest, with both counts at zero."""
        self.last_refused = False
        self._settings = settings
        self._clipped = self._refused = 0
        self._followed = np.zeros(2)
        self._followed_at = -math.inf

    def change_settings(self, settings: Settings) -> None:
        """Uses other settings from now on."""
        self._settings = settings

    def followed(self, twist: Twist, now: float) -> tuple[np.ndarray, float]:
        """The part of a command received at `now` [s] that is followed: within the limits, or zero if refused.

        It is a velocity (2,) [m/s, robot frame] and a yaw rate [rad/s].
        """
        settings = self._settings
        try:
            velocity, yaw_rate = velocity_from_twist(twist)
            accepted = clip_command(velocity, yaw_rate, settings.robot, settings.limits)
        except MessageError:
            accepted = None
        self.last_refused = accepted is None
        if accepted is None:
            self._refused += 1
            self._follow(np.zeros(2), now)
            return np.zeros(2), 0.0
        clipped, turn = accepted
        self._clipped += not np.array_equal(clipped, velocity)
        self._follow(self._capped(clipped, now), now)
        return self._followed, turn

    @property
    def counts(self) -> dict[str, int]:
        """Clipped and refused commands so far, as values of a `Health`."""
        return {"clipped": self._clipped, "refused": self._refused}

    def _capped(self, velocity: np.ndarray, now: float) -> np.ndarray:
        """The velocity (2,) within both caps; a stop is never slowed."""
        settings = self._settings
        period = 1.0 / settings.controller.rate
        silent = now - self._followed_at > settings.limits.command_age
        before, passed = (np.zeros(2), period) if silent else (self._followed, min(now - self._followed_at, period))
        wanted = cut_to_bounds(velocity, velocity_bounds(replace(settings.robot, max_speed=settings.cap.speed)))
        if not wanted.any():
            return wanted
        return before + saturate(wanted - before, settings.cap.acceleration * passed)

    def _follow(self, velocity: np.ndarray, now: float) -> None:
        self._followed, self._followed_at = velocity, now
