"""Progress of the robot to its goal: time, the way since it last came nearer, where it stays, and no way there."""

import math

import numpy as np

from collplan_core.movers.record import Movers
from collplan_core.parameters import Planning

STEP = 0.05
"""The way is measured between places so far apart: noise of the poses is no way [m]."""
ABOUT, PATIENCE, SLOWEST = 1.5, 20.0, 0.2
"""A robot that goes no farther than ABOUT [m] within PATIENCE [s] stays; a slower one than SLOWEST [m/s] longer."""
IDLE = 5.0
"""One that was commanded nothing for so long though there are plans is held by something else [s]."""
CLOSED_OFF_TIME = 2.0
"""A goal that cannot be reached in the known map for this long is given up [s]."""
BESIDE = 1.5
"""A mover whose centre is so near may be in its way [m]."""


class Progress:
    """What the loop is told on the way to a goal, and the reasons to give the goal up; times on the local clock [s]."""

    def __init__(self) -> None:
        """Starts without a place."""
        self.begin_goal(0.0)

    def begin_goal(self, local: float) -> None:
        """Starts anew, for another goal given at `local` [s]."""
        self._given = local
        self.begin_poses()

    def begin_poses(self) -> None:
        """Starts anew after a break in the poses, but for the time since the goal was given."""
        self._nearest, self._way = math.inf, 0.0  # least distance to the goal, way driven since then [m]
        self._place: list[float] | None = None
        self._commanded = -math.inf
        self.may_be_open()
        self.leave()

    def leave(self) -> None:
        """Counts no time up to now: a person drove or held the robot, or nothing could be planned."""
        # why there was no way to the goal while it stayed, and where a mover was last beside it; "" without
        self._closed = self._mover = ""
        self._about: tuple[np.ndarray, float] | None = None

    def may_be_open(self) -> None:
        """Forgets that no way led to the goal."""
        self._closed_since: float | None = None

    def why_overdue(self, local: float, planning: Planning, remembers: bool) -> str:
        """Returns why the goal takes too long, or too much way with a planner that does not remember; "" else."""
        if 0.0 < planning.goal_timeout < local - self._given:
            return f"not reached within planner.goal_timeout, {planning.goal_timeout:g} s"
        if not remembers and 0.0 < planning.longest_detour < self._way:
            way = f"driven {self._way:.0f} m without coming nearer than {self._nearest:.2f} m"
            return f"{way}; limit planner.longest_detour, {planning.longest_detour:g} m"
        return ""

    def why_closed_off(self, reason: str, local: float) -> str:
        """Notes why no way leads to the goal at `local`; returns it once that has lasted CLOSED_OFF_TIME, else ""."""
        self._closed = reason
        if self._closed_since is None:
            self._closed_since = local
        return self._hindered if local - self._closed_since >= CLOSED_OFF_TIME else ""

    @property
    def _hindered(self) -> str:
        return "; ".join(filter(None, (self._closed, self._mover)))

    def commanded(self, velocity: np.ndarray, local: float) -> None:
        """Takes a velocity (2,) [m/s] commanded from `local` on [s, local clock]."""
        if velocity.any():
            self._commanded = local

    def planned(self, local: float) -> None:
        """Notes a plan at `local` [s, local clock]."""
        if local - self._commanded > IDLE and not self._closed:
            self.leave()

    def why_no_further(
        self, position: np.ndarray, goal: np.ndarray, movers: Movers, fastest: float, local: float
    ) -> str:
        """Returns why a robot stays about its position (2,) [m] at `local` [s] instead of going to a goal (2,) [m].

        "" where it does not; one that nothing is in the way of may stay, as one that plans nothing may. Notes what
        moves beside it. `fastest` is its top speed [m/s].
        """
        if self._about is None or math.dist(position, self._about[0]) > ABOUT:
            self.leave()
            self._about = position, local
        patience = PATIENCE * max(1.0, SLOWEST / fastest)
        stays = bool(self._hindered) and local - self._about[1] >= patience
        why = f"it stayed within {ABOUT:g} m for {patience:g} s: {self._hindered}" if stays else ""
        away = np.hypot(*(movers.positions - position).T)
        if len(away) and away.min() < BESIDE:
            x, y = movers.positions[away.argmin()]
            on_goal = " on the goal" if math.dist((x, y), goal) < movers.radii[away.argmin()] else ""
            self._mover = f"a mover{on_goal}, last seen at {x:.2f}, {y:.2f}"
        return why

    def moved(self, position: np.ndarray, goal: np.ndarray, least: float) -> None:
        """Takes a position (2,) on the way to a goal (2,) [m]; nearer by less than `least` [m] is not nearer."""
        place = position.tolist()
        distance = math.dist(place, goal.tolist())
        if distance < self._nearest - least:
            self._nearest, self._way, self._place = distance, 0.0, place
        elif self._place is not None and (step := math.dist(place, self._place)) >= STEP:
            self._way, self._place = self._way + step, place
