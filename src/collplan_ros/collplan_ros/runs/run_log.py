"""What is remembered of a run, in plain records; times are stamps on the poses' clock [s], vectors world frame.

`sent` is when a node handed a message to its middleware [s, wall clock]. What carries no stamp is ordered by it: a
listener that is kept waiting takes the topics' backlogs in no common order.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import numpy as np

from collplan_core.command import STOPPED
from collplan_core.plan import Contacts
from collplan_core.scan import Scan


class PoseRow(NamedTuple):
    """Where the robot is [m, rad] and how fast it moves [m/s, world frame]; `sent` is NaN where it is not needed."""

    stamp: float
    x: float
    y: float
    yaw: float
    vx: float
    vy: float
    sent: float = math.nan


class SentCommand(NamedTuple):
    """A body-frame command [m/s, rad/s]."""

    sent: float
    vx: float
    vy: float
    wz: float


class SentManeuver(NamedTuple):
    """The controller has begun a maneuver."""

    sent: float
    name: str


class SentReference(NamedTuple):
    """The point that the controller tracks [m]."""

    sent: float
    x: float
    y: float


class CommandRow(NamedTuple):
    """A body-frame command [m/s, rad/s], placed on the poses' clock, and the maneuver that it belongs to."""

    stamp: float
    sent: float
    vx: float
    vy: float
    wz: float
    maneuver: str


class ImpactRecord(NamedTuple):
    """A change of velocity by a hit [m/s, world frame]."""

    stamp: float
    dvx: float
    dvy: float


@dataclass(frozen=True, eq=False)
class PlanRow:
    """A plan: stamp of what it was made from, times (n,) and positions (n, 2)."""

    stamp: float
    times: np.ndarray
    positions: np.ndarray


@dataclass
class RunLog:
    """Everything received, each list in order.

    `detected` holds the hits seen in the poses, `kicks` the simulator's true ones; `told_reached` is when the planner
    sent that the goal is reached.
    """

    poses: list[PoseRow] = field(default_factory=list)
    truth: list[PoseRow] = field(default_factory=list)
    sent_commands: list[SentCommand] = field(default_factory=list)
    sent_maneuvers: list[SentManeuver] = field(default_factory=list)
    sent_references: list[SentReference] = field(default_factory=list)
    plans: list[PlanRow] = field(default_factory=list)
    contacts: dict[float, Contacts] = field(default_factory=dict)
    scans: list[Scan] = field(default_factory=list)
    impact_records: list[ImpactRecord] = field(default_factory=list)
    detected: list[ImpactRecord] = field(default_factory=list)
    costs: list[dict[str, float]] = field(default_factory=list)
    told_reached: float | None = None

    @property
    def hits(self) -> list[ImpactRecord]:
        """The true hits where a simulator tells them, else the detected ones."""
        return self.impact_records if self.truth else self.detected

    @property
    def track(self) -> list[PoseRow]:
        """The true path where a simulator tells it, else the measured one."""
        return self.truth or self.poses

    @property
    def time_zero(self) -> float | None:
        """Stamp of the first non-zero command."""
        moving = next((c for c in self.sent_commands if c.vx or c.vy or c.wz), None)
        return None if moving is None or not self.poses else self.stamp_at(moving.sent)

    @property
    def begin(self) -> float:
        """Where t = 0 in the files of a run: time zero, or the first pose where the robot was never commanded."""
        first = self.poses[0].stamp if self.poses else 0.0
        return first if self.time_zero is None else self.time_zero

    @property
    def arrival(self) -> float:
        """Stamp of a reached goal: of the last pose, or of the planner's word where poses before that one were lost."""
        last = self.poses[-1].stamp
        return last if self.told_reached is None else min(last, self.stamp_at(self.told_reached))

    @property
    def commands(self) -> list[CommandRow]:
        """Every command on the poses' clock; none before the first pose is there."""
        if not self.poses:
            return []
        # the controller names a new maneuver just after the command that begins it
        following = [*(c.sent for c in self.sent_commands[1:]), math.inf]
        pairs = zip(self.sent_commands, following, strict=True)
        return [CommandRow(self.stamp_at(c.sent), *c, self.maneuver_at(end)) for c, end in pairs]

    def stamp_at(self, sent: float) -> float:
        """The poses' clock when something was sent [s]: the stamp of the newest pose sent by then, and the time since.

        It takes at least one pose.
        """
        pose = _newest(self.poses, sent) or self.poses[0]
        return pose.stamp + sent - pose.sent

    def maneuver_at(self, sent: float) -> str:
        """The maneuver told last by then."""
        told = _newest(self.sent_maneuvers, sent)
        return told.name if told else STOPPED

    def command_at(self, sent: float) -> SentCommand | None:
        """The command sent last by then."""
        return _newest(self.sent_commands, sent)

    def reference_at(self, sent: float) -> SentReference | None:
        """The point tracked then; none while the robot is stopped."""
        return None if self.maneuver_at(sent) == STOPPED else _newest(self.sent_references, sent)


Sent = TypeVar("Sent", PoseRow, SentCommand, SentManeuver, SentReference)


def _newest(rows: Sequence[Sent], sent: float) -> Sent | None:
    following = bisect_right(rows, sent, key=lambda row: row.sent)
    return rows[following - 1] if following else None
