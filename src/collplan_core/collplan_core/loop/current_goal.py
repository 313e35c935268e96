"""The goal that the planner plans for, from acceptance until it is reached or ends for another reason."""

import math
from dataclasses import replace

import numpy as np

from collplan_core.goal import ABORTED, EXECUTING, NO_GOAL, Goal

CLOSED_OFF_TIME = 2.0
"""A goal that cannot be reached in the known map for this long is given up [s]."""


class CurrentGoal:
    """The newest goal, if any, and the time of its last change. Methods that change it return the goal to publish."""

    def __init__(self) -> None:
        """Starts without a goal."""
        self.goal: Goal | None = None  # the newest; None before the first
        self._since = 0.0
        self._closed_since: float | None = None

    @property
    def active(self) -> bool:
        """True where there is a goal that the robot is to drive to."""
        return self.goal is not None and self.goal.active

    @property
    def position(self) -> np.ndarray:
        """Position of the newest goal (2,) [m]; there must be one."""
        assert self.goal is not None
        return self.goal.position

    @property
    def status(self) -> str:
        """Status of the newest goal."""
        return NO_GOAL if self.goal is None else self.goal.status

    def accept(self, goal: Goal, local: float, again: bool = False) -> Goal:
        """Replaces the goal. Its time counts from `local` [s, local clock], or continues where it is given `again`."""
        self._since = self._since if again else local
        self.goal, self._closed_since = goal, None
        return goal

    def refuse(self, goal: Goal) -> Goal:
        """Takes an invalid goal as aborted; this ends the previous one too."""
        self.goal = replace(goal, status=ABORTED)
        return self.goal

    def become(self, status: str) -> Goal | None:
        """Sets the status; returns the goal if the status is a new one."""
        assert self.goal is not None
        if status == self.goal.status:
            return None
        self.goal = replace(self.goal, status=status)
        return self.goal

    def planned(self) -> Goal | None:
        """Notes that a plan leads to the goal; returns the goal at the first one."""
        self._closed_since = None
        return self.become(EXECUTING)

    def restamp(self, stamp: float) -> Goal | None:
        """Gives an active goal a new stamp [s], so that every plan made up to then is refused; returns it, if any."""
        if self.goal is None or not self.goal.active:
            return None
        self._closed_since = None
        self.goal = replace(self.goal, stamp=stamp)
        return self.goal

    def is_at(self, position: np.ndarray, tolerance: float) -> bool:
        """Returns whether an active goal is within `tolerance` [m] of a position (2,) [m]."""
        return self.active and math.dist(position.tolist(), self.position.tolist()) <= tolerance

    def is_overdue(self, local: float, timeout: float) -> bool:
        """Returns whether the goal was not reached within `timeout` [s] by `local` [s, local clock]; never for 0."""
        return bool(timeout) and local - self._since > timeout

    def may_be_open(self) -> None:
        """Forgets that no way led to the goal."""
        self._closed_since = None

    def is_closed_off(self, local: float) -> bool:
        """Notes that no way leads to the goal at `local` [s, local clock]; whether that lasted CLOSED_OFF_TIME."""
        if self._closed_since is None:
            self._closed_since = local
        return local - self._closed_since >= CLOSED_OFF_TIME
