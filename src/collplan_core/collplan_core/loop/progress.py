"""The way driven since the robot last came nearer to its goal, and how long it has stayed about one place."""

import math

import numpy as np

from collplan_core.movers.record import Movers

STEP = 0.05
"""The way is measured between places so far apart: noise of the poses is no way [m]."""
ABOUT, PATIENCE, SLOWEST = 1.5, 20.0, 0.2
"""A robot that goes no farther than ABOUT [m] within PATIENCE [s] stays; a slower one than SLOWEST [m/s] longer."""
IDLE = 5.0
"""One that was commanded nothing for so long though there are plans is held by something else [s]."""
BESIDE = 1.5
"""A mover whose centre is so near may be in its way [m]."""


class Progress:
    """The least distance to a goal, the way since then, and the place about which the robot stays."""

    def __init__(self) -> None:
        """Starts without a place."""
        self.begin_goal()

    def begin_goal(self) -> None:
        """Starts anew, for another goal or after a break in the poses."""
        self.nearest, self.way = math.inf, 0.0  # least distance to the goal, way driven since then [m]
        self._place: list[float] | None = None
        self._commanded = -math.inf
        self.leave()

    def leave(self) -> None:
        """Counts no time up to now: a person drove or held the robot, or nothing could be planned."""
        # why there was no way to the goal while it stayed, and where a mover was last beside it; "" without
        self.closed = self.mover = ""
        self._about: tuple[np.ndarray, float] | None = None

    def commanded(self, velocity: np.ndarray, local: float) -> None:
        """Takes a velocity (2,) [m/s] commanded from `local` on [s, local clock]."""
        if velocity.any():
            self._commanded = local

    def planned(self, local: float) -> None:
        """Notes a plan at `local` [s, local clock]."""
        if local - self._commanded > IDLE and not self.closed:
            self.leave()

    def beside(self, movers: Movers, position: np.ndarray, goal: np.ndarray) -> None:
        """Notes what moves beside a robot at a position on its way to a goal (2,) [m]."""
        away = np.hypot(*(movers.positions - position).T)
        if len(away) and away.min() < BESIDE:
            x, y = movers.positions[away.argmin()]
            on_goal = " on the goal" if math.dist((x, y), goal) < movers.radii[away.argmin()] else ""
            self.mover = f"a mover{on_goal}, last seen at {x:.2f}, {y:.2f}"

    def why_no_further(self, position: np.ndarray, fastest: float, local: float) -> str:
        """Returns why a robot stays about its position (2,) [m] at `local` [s, local clock]; "" where it does not.

        One that nothing is in the way of may stay, as one that plans nothing may. `fastest` is its top speed [m/s].
        """
        if self._about is None or math.dist(position, self._about[0]) > ABOUT:
            self.leave()
            self._about = position, local
        patience = PATIENCE * max(1.0, SLOWEST / fastest)
        hindered = "; ".join(filter(None, (self.closed, self.mover)))
        if not hindered or local - self._about[1] < patience:
            return ""
        return f"it stayed within {ABOUT:g} m for {patience:g} s: {hindered}"

    def moved(self, position: np.ndarray, goal: np.ndarray, least: float) -> None:
        """Takes a position (2,) on the way to a goal (2,) [m]; nearer by less than `least` [m] is not nearer."""
        place = position.tolist()
        distance = math.dist(place, goal.tolist())
        if distance < self.nearest - least:
            self.nearest, self.way, self._place = distance, 0.0, place
        elif self._place is not None and (step := math.dist(place, self._place)) >= STEP:
            self.way, self._place = self.way + step, place
