"""The way driven since the robot last came nearer to its goal."""

import math

import numpy as np

STEP = 0.05
"""The way is measured between places so far apart: noise of the poses is no way [m]."""


class Progress:
    """The least distance to a goal, and the way since then.

    Attributes:
        nearest: least distance to the goal [m]; infinite before the first pose.
        way: way driven since the robot was that near [m].
    """

    def __init__(self) -> None:
        """Starts without a place."""
        self.begin_goal()

    def begin_goal(self) -> None:
        """Starts anew, for another goal or after a break in the poses."""
        self.nearest, self.way = math.inf, 0.0
        self._place: list[float] | None = None

    def moved(self, position: np.ndarray, goal: np.ndarray, least: float) -> None:
        """Takes a position (2,) on the way to a goal (2,) [m]; nearer by less than `least` [m] is not nearer."""
        place = position.tolist()
        distance = math.dist(place, goal.tolist())
        if distance < self.nearest - least:
            self.nearest, self.way, self._place = distance, 0.0, place
        elif self._place is not None and (step := math.dist(place, self._place)) >= STEP:
            self.way, self._place = self.way + step, place
