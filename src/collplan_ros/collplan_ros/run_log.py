"""What is remembered of a run, in plain records; times are stamps on the poses' clock [s], vectors world frame."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from collplan_core.command import STOPPED
from collplan_core.plan import Contacts
from collplan_core.scan import Scan


class PoseRow(NamedTuple):
    """Where the robot is [m, rad] and how fast it moves [m/s, world frame]."""

    stamp: float
    x: float
    y: float
    yaw: float
    vx: float
    vy: float


class CommandRow(NamedTuple):
    """A body-frame command [m/s, rad/s]; `sent` is the controller's own wall clock [s]."""

    stamp: float
    sent: float
    vx: float
    vy: float
    wz: float
    maneuver: str


class Kick(NamedTuple):
    """A change of velocity by a hit [m/s, world frame]."""

    stamp: float
    dvx: float
    dvy: float


@dataclass(frozen=True, eq=False)
class PlanRow:
    """A plan: stamp of its scan, times (n,) and positions (n, 2)."""

    stamp: float
    times: np.ndarray
    positions: np.ndarray


@dataclass
class RunLog:
    """Everything received, in order.

    `detected` holds the hits seen in the poses, `kicks` the simulator's true ones; `reference` is the point that the
    controller tracks now.
    """

    poses: list[PoseRow] = field(default_factory=list)
    truth: list[PoseRow] = field(default_factory=list)
    commands: list[CommandRow] = field(default_factory=list)
    plans: list[PlanRow] = field(default_factory=list)
    contacts: dict[float, Contacts] = field(default_factory=dict)
    scans: list[Scan] = field(default_factory=list)
    kicks: list[Kick] = field(default_factory=list)
    detected: list[Kick] = field(default_factory=list)
    costs: list[dict[str, float]] = field(default_factory=list)
    maneuver: str = STOPPED
    reference: tuple[float, float] | None = None

    @property
    def hits(self) -> list[Kick]:
        """The true hits where a simulator tells them, else the detected ones."""
        return self.kicks if self.truth else self.detected

    @property
    def track(self) -> list[PoseRow]:
        """The true path where a simulator tells it, else the measured one."""
        return self.truth or self.poses

    @property
    def time_zero(self) -> float | None:
        """Stamp of the first non-zero command."""
        return next((c.stamp for c in self.commands if c.vx or c.vy or c.wz), None)
