"""Records of a run; times are stamps on the poses' clock [s], vectors are in the world frame.

`sent` is the time at which a node passed a message to its middleware [s, steady clock]. It orders messages without a
stamp: a subscriber that falls behind receives the backlogs of its topics in no common order.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import numpy as np

from collplan_core.command import STOPPED, WITHOUT_REFERENCE
from collplan_core.impact import SIMULATED, Impact
from collplan_core.plan import Contacts
from collplan_core.state import State


class PoseRow(NamedTuple):
    """Pose [m, rad] and velocity [m/s, world frame] of the robot; `sent` is NaN where it is not needed."""

    stamp: float
    x: float
    y: float
    yaw: float
    vx: float
    vy: float
    sent: float = math.nan

    @property
    def state(self) -> State:
        """The robot's state."""
        return State(self.stamp, np.array([self.x, self.y]), np.array([self.vx, self.vy]), self.yaw)


class SentCommand(NamedTuple):
    """A command in the robot's frame [m/s, rad/s], with the time it was sent."""

    sent: float
    vx: float
    vy: float
    wz: float


class SentManeuver(NamedTuple):
    """The maneuver that the controller began, with the time it was sent."""

    sent: float
    name: str


class SentReference(NamedTuple):
    """The point that the controller tracked [m], with the time it was sent."""

    sent: float
    x: float
    y: float


class SentGoal(NamedTuple):
    """A goal [m] that bringup gave, with the time it was given."""

    sent: float
    x: float
    y: float


class SentStatus(NamedTuple):
    """Status of the goal given last, as `collplan_core.goal` names it, with the time it was sent."""

    sent: float
    status: str


class CommandRow(NamedTuple):
    """A command in the robot's frame [m/s, rad/s], with its time on the poses' clock and its maneuver."""

    stamp: float
    sent: float
    vx: float
    vy: float
    wz: float
    maneuver: str


@dataclass
class RunLog:
    """Everything recorded of a run, each list in order of receipt.

    Attributes:
        simulated: whether the robot was simulated.
        poses: measured poses.
        truth: true poses, of a simulated robot only.
        sent_commands: commands of the controller.
        sent_maneuvers: maneuvers begun.
        sent_references: points tracked.
        plans: contacts foreseen by each plan, by its stamp [s].
        impacts: impacts, also those that are measured beside the simulated ones, in order of receipt.
        costs: figures of each planning cycle.
        goals: goals given.
        statuses: the planner's reports on them.
        reached_sent: send time of the planner's report that the goal is reached; None before.
        drive: figures of the drive in use and what was learnt of it, newest; empty where nothing was.
        drive_in_words: the same for people.
        pace: seconds of stamps per second of the clock of `sent`; 0 where that varies.
    """

    simulated: bool = False
    poses: list[PoseRow] = field(default_factory=list)
    truth: list[PoseRow] = field(default_factory=list)
    sent_commands: list[SentCommand] = field(default_factory=list)
    sent_maneuvers: list[SentManeuver] = field(default_factory=list)
    sent_references: list[SentReference] = field(default_factory=list)
    plans: dict[float, Contacts] = field(default_factory=dict)
    impacts: list[Impact] = field(default_factory=list)
    costs: list[dict[str, float]] = field(default_factory=list)
    goals: list[SentGoal] = field(default_factory=list)
    statuses: list[SentStatus] = field(default_factory=list)
    reached_sent: float | None = None
    drive: dict[str, float] = field(default_factory=dict)
    drive_in_words: str = ""
    pace: float = 1.0

    @property
    def goal(self) -> np.ndarray:
        """(2,) the goal given last [m]; NaN before the first."""
        return np.array(self.goals[-1][1:]) if self.goals else np.full(2, math.nan)

    @property
    def track(self) -> list[PoseRow]:
        """The true poses of a simulated robot, else the measured ones."""
        return self.truth or self.poses

    @property
    def time_zero(self) -> float | None:
        """Time of the first non-zero command [s]; None where there was none, or no pose."""
        moving = next((c for c in self.sent_commands if c.vx or c.vy or c.wz), None)
        return None if moving is None or not self.poses else self.stamp_at(moving.sent)

    @property
    def begin(self) -> float:
        """Time of t = 0 in the files of a run [s]: `time_zero`, or the first pose if the robot was never commanded."""
        first = self.poses[0].stamp if self.poses else 0.0
        return first if self.time_zero is None else self.time_zero

    @property
    def arrival(self) -> float:
        """Time at which the goal was reached [s]: of the last pose, or of the planner's report if that is earlier."""
        last = self.poses[-1].stamp
        return last if self.reached_sent is None else min(last, self.stamp_at(self.reached_sent))

    @property
    def commands(self) -> list[CommandRow]:
        """Every command with its time on the poses' clock; empty without poses."""
        if not self.poses or not self.sent_commands:
            return []
        # the controller names a new maneuver just after the command that begins it
        following = [*(c.sent for c in self.sent_commands[1:]), math.inf]
        pairs = zip(self.sent_commands, following, strict=True)
        return [CommandRow(self.stamp_at(c.sent), *c, self.maneuver_at(end)) for c, end in pairs]

    def stamp_at(self, sent: float) -> float:
        """Time on the poses' clock at a time of sending [s]: stamp of the newest pose sent by then, and the time since.

        The log must hold a pose.
        """
        pose = _newest(self.poses, sent) or self.poses[0]
        return pose.stamp + self.pace * (sent - pose.sent)

    @property
    def own_impacts(self) -> list[Impact]:
        """The impacts of the run: of a simulated robot the simulated ones, else those that were measured."""
        return [each for each in self.impacts if (each.source == SIMULATED) == bool(self.truth)]

    def maneuver_at(self, sent: float) -> str:
        """Name of the last maneuver sent by then; STOPPED before the first."""
        maneuver = _newest(self.sent_maneuvers, sent)
        return maneuver.name if maneuver else STOPPED

    def command_at(self, sent: float) -> SentCommand | None:
        """The last command sent by then; None before the first."""
        return _newest(self.sent_commands, sent)

    def end_with(self, stamp: float, sent: float) -> None:
        """Removes everything after a pose of this stamp [s] that was sent then [s]; figures of planning cycles stay."""
        for rows in (self.poses, self.sent_commands, self.sent_maneuvers, self.sent_references):
            del rows[bisect_right(rows, sent, key=lambda row: row.sent) :]
        del self.truth[bisect_right(self.truth, stamp, key=lambda row: row.stamp) :]
        self.impacts = [impact for impact in self.impacts if impact.time <= stamp]
        for made in [made for made in self.plans if made > stamp]:
            del self.plans[made]

    def reference_at(self, sent: float) -> SentReference | None:
        """The point tracked at that time; None while the robot is stopped, or before the first."""
        return None if self.maneuver_at(sent) in WITHOUT_REFERENCE else _newest(self.sent_references, sent)


Sent = TypeVar("Sent", PoseRow, SentCommand, SentManeuver, SentReference)


def _newest(rows: Sequence[Sent], sent: float) -> Sent | None:
    following = bisect_right(rows, sent, key=lambda row: row.sent)
    return rows[following - 1] if following else None
