"""A goal and its status."""

import math
from dataclasses import dataclass

import numpy as np

NO_GOAL = "none"
ACCEPTED, EXECUTING, SUCCEEDED, CANCELED, ABORTED = "accepted", "executing", "succeeded", "canceled", "aborted"
ACTIVE = ACCEPTED, EXECUTING
"""Status of a goal that the robot is to go to."""
AT_REST = 0.05
"""A robot slower than this counts as at rest: poses cannot show the difference [m/s]."""


@dataclass(frozen=True, eq=False)
class Goal:
    """A goal with the stamp from which on plans are made for it."""

    id: bytes  # 16 bytes, different for every goal
    stamp: float  # stamp of the newest pose when the goal was accepted [s]; only plans with a later stamp are for it
    position: np.ndarray  # (2,) [m], NaN where it was refused or is not known
    status: str = ACCEPTED  # NO_GOAL, ACCEPTED, EXECUTING (there was a plan for it), SUCCEEDED, CANCELED or ABORTED

    @property
    def active(self) -> bool:
        """True where the robot is to drive to it."""
        return self.status in ACTIVE

    def is_at(self, position: np.ndarray, tolerance: float) -> bool:
        """Returns whether it is active and within `tolerance` [m] of a position (2,) [m]."""
        return self.active and math.dist(position.tolist(), self.position.tolist()) <= tolerance


NOT_GIVEN = Goal(b"", 0.0, np.full(2, np.nan), NO_GOAL)
"""The goal of a loop that was given none yet."""
