"""A strategy of collplan as a policy of `collplan/Bounce-v0`: the planner and controller that a robot runs."""

import math
from typing import Any

import numpy as np

from collplan_core.loop.closed_loop import ClosedLoop
from collplan_core.loop.decisions import Cycle, Decision
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.plane import rotate
from collplan_core.planners import map_period_of
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.validation import check_type
from collplan_core.worlds.raycast import beam_increment

SOON = 1e-6
"""A plan that is due within this time is due [s]."""


class PlannerPolicy:
    """Observation and `info` in, action out; begins anew where the stamp goes back, as after `reset`.

    The strategy is a value of `planner.strategy`, such as bounce, avoid, harness; the settings are those of the
    environment, the shipped ones by default.

    Raises:
        ParameterError: unknown strategy.
        TypeError: settings of another type.
    """

    def __init__(self, strategy: str, settings: Settings | None = None) -> None:
        given = Settings() if settings is None else settings
        check_type("settings", given, Settings, ", as in Settings()")
        self._settings = given.with_values({"planner.strategy": strategy})
        self._stamp, self._due = math.inf, -math.inf
        self.plan: Plan | None = None  # the newest; None before the first

    def __call__(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> np.ndarray:
        """The velocity (2,) to command [m/s, body frame]."""
        stamp, (x, y, yaw) = info["stamp"], info["pose"].tolist()
        begins = stamp <= self._stamp
        if begins:
            self._begin()
        self._stamp = stamp
        for at, *change in info["changes"]:
            self._loop.take_impact(at, np.array(change), at)
        for at, px, py, vx, vy, heading in info["states"]:
            self._loop.take_pose(State(at, np.array([px, py]), np.array([vx, vy]), heading), at)
        if begins:
            ahead, left = rotate(*observation["goal"].tolist(), yaw)
            self._loop.take_goal(np.array([x + ahead, y + left]), stamp)
        self._loop.take_scan(self._scan(observation["scan"]), stamp)
        if stamp >= self._due - SOON:
            self._due = stamp + map_period_of(self._settings.planner)
            self._loop.plan(stamp)
        return np.asarray(self._loop.tick(stamp).velocity, dtype=np.float32)

    def _begin(self) -> None:
        self._loop = ClosedLoop(self._settings, self._hear)
        self.plan, self._due = None, -math.inf

    def _hear(self, decision: Decision, _: float) -> None:
        if isinstance(decision, Cycle):
            self.plan = decision.plan

    def _scan(self, ranges: np.ndarray) -> Scan:
        lidar = self._settings.lidar
        seen = np.where(ranges < np.float32(lidar.range_max), ranges.astype(float), math.inf)
        increment = beam_increment(lidar)
        return Scan(self._stamp, lidar.angle_min, increment, lidar.range_min, lidar.range_max, seen)
