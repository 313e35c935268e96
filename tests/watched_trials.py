"""Trials whose controller is watched: what it commanded and why, what it said of the motion, where it saw the robot."""

import math
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np

from collplan_core.command import Command
from collplan_core.parameters import Settings
from collplan_core.poses.pose_filter import PoseSample
from collplan_core.worlds import World
from omnipuck_sim.trial import TrialNodes, run_trial

VISIBLE = 0.01
"""Way from which a motion is seen [m]."""


class Said(NamedTuple):
    """A control period: time [s], speed commanded [m/s], why it stands, why it is held, verdict on the motion."""

    time: float
    speed: float
    reason: str
    held: str
    kind: str


class Watched(TrialNodes):
    """A trial's nodes.

    Attributes:
        said: each control period.
        poses: time [s] and place x, y [m] of each pose that controller and planner took.
        result: of the trial, once it is over.
    """

    def __init__(self, *given) -> None:
        super().__init__(*given)
        self.said: list[Said] = []
        self.poses: list[tuple[float, float, float]] = []
        record = self.record.commanded

        def commanded(command: Command, now: float) -> None:
            controller, speed = self.loop.controller, float(np.hypot(*command.velocity))
            self.said.append(Said(now, speed, command.reason, controller.held, controller.motion.verdict.kind))
            record(command, now)

        self.record.commanded = commanded

    def mocap(self) -> None:
        super().mocap()
        if self._state is not None:
            self.poses.append((self.simulator.time, *self._state.position.tolist()))

    @property
    def seen_moving(self) -> float:
        """When the first motion was seen [s]."""
        _, x, y = self.poses[0]
        return next(t for t, px, py in self.poses if math.hypot(px - x, py - y) > VISIBLE)

    @property
    def last_moving_command(self) -> float:
        """When the last command was sent that moves [s]."""
        return max((row.time for row in self.said if row.speed > 0.0), default=-math.inf)


class FalsePoses(Watched):
    """The same with a fault of its poses from a time on, for so long [s]."""

    def __init__(self, fault: Callable[[PoseSample], PoseSample], at: float, lasts: float, *given) -> None:
        super().__init__(*given)
        self.fault, self.at, self.lasts = fault, at, lasts

    def measure(self) -> None:
        super().measure()
        if self.at <= self.simulator.time < self.at + self.lasts:
            self.measured.append(self.fault(self.measured.pop()))


class Turned(Watched):
    """The same with wheels that drive the robot at an angle [rad] to where they should."""

    def __init__(self, angle: float, *given) -> None:
        super().__init__(*given)
        c, s = math.cos(angle), math.sin(angle)
        command, matrix = self.simulator.command, np.array([[c, -s], [s, c]])
        self.simulator.command = lambda velocity, yaw_rate: command(matrix @ np.asarray(velocity), yaw_rate)


T = TypeVar("T", bound=Watched)


def watched_trial(world: World, strategy: str, seed: int, nodes: Callable[..., T] = Watched, **values) -> T:
    """The nodes of a trial that is over, with these parameters (`__` for the dot)."""
    made: list[T] = []

    def make(*given) -> T:
        made.append(nodes(*given))
        return made[0]

    named = {key.replace("__", "."): value for key, value in values.items()}
    settings = Settings().with_values({"planner.strategy": strategy, **named})
    result = run_trial(world, settings, seed, nodes_class=make)
    made[0].result = result
    return made[0]
