"""Driving there and back, again and again, for people who watch."""

import time
from collections.abc import Callable
from itertools import cycle
from typing import Protocol

import numpy as np

from collplan_core.evaluation.run_end import CANCELED, REACHED

PAUSE = 1.0
"""Rest at each end [s]."""
EMERGENCY_STOP = "emergency_stop"
"""Outcome of a run in which the robot's emergency stop was latched."""
BY_A_PERSON = (CANCELED, EMERGENCY_STOP)
"""Outcomes after which the robot stands until a person gives a goal."""


class Driver(Protocol):
    """What drives a lap."""

    def drive(self, goal: np.ndarray | None = None) -> str:
        """Drives to a goal (2,) [m] and returns the outcome."""

    def come_to_rest(self) -> None:
        """Ends a goal that has not ended, and waits until the robot rests."""

    def wait(self, condition: Callable[[], bool]) -> None:
        """Lets the graph run until a condition holds."""

    def reason(self, outcome: str) -> str:
        """Why a goal was not reached, in words."""

    @property
    def goal_is_active(self) -> bool:
        """Whether the robot is on the way to a goal, whoever gave it."""


def drive_laps(driver: Driver, ends: list[np.ndarray], say: Callable[[str], None]) -> None:
    """Drives from end (2,) [m] to end until an exception ends it: a signal, or what has gone wrong.

    A person may give goals in between. Where one cancels, or stops the robot, it stands until one gives a goal.
    """
    for target in cycle(ends):
        outcome = driver.drive(target)
        driver.come_to_rest()
        if outcome in BY_A_PERSON:
            say(f"{outcome.replace('_', ' ')}: the robot stands until you give it a goal")
            driver.wait(lambda: driver.goal_is_active)
            driver.wait(lambda: not driver.goal_is_active)
        elif outcome != REACHED:
            say(driver.reason(outcome))
        _rest(driver)


def _rest(driver: Driver) -> None:
    begun = time.monotonic()
    driver.wait(lambda: time.monotonic() - begun > PAUSE)
