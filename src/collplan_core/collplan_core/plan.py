"""Output of every planner: a plan, or the reason why there is none."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from collplan_core.validation import finite, rising


@dataclass(frozen=True, eq=False)
class Contacts:
    """Foreseen contacts, world frame."""

    times: np.ndarray  # (k,) [s]
    points: np.ndarray  # (k, 2) where the ring touches the obstacle, not the disc's centre [m]
    velocities_after: np.ndarray  # (k, 2) [m/s]
    normals: np.ndarray  # (k, 2) unit normals out of the obstacles; NaN where they are unknown
    speeds: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """(k,) into the obstacle [m/s]; empty where they are unknown, as in a plan read from a message."""

    @property
    def hardest(self) -> float:
        """The largest speed into an obstacle [m/s]; 0 without a contact, or where it is not known."""
        return float(self.speeds.max(initial=0.0))

    @staticmethod
    def none() -> "Contacts":
        """No contact foreseen."""
        return Contacts(np.zeros(0), *np.zeros((3, 0, 2)))


@dataclass(frozen=True, eq=False)
class Candidates:
    """Candidates from which a plan was chosen, for display."""

    positions: np.ndarray  # positions, velocities: (m, 2) [m], [m/s]
    velocities: np.ndarray
    costs: np.ndarray  # (m,) cost of each candidate
    paths: tuple[np.ndarray, ...] = ()  # (k, 2) whole paths that the best was refined from, if any [m]
    path_costs: tuple[float, ...] = ()  # cost of each of these paths
    terms: Mapping[str, np.ndarray] = field(default_factory=dict)
    """(m,) each cost term by its name, where they are computed separately."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A timed reference and how it was chosen, world frame."""

    stamp: float  # start of the plan [s], the stamp of the state it was made from; the robot is at positions[0] then
    times: np.ndarray  # (n,) time of each position, strictly rising, times[0] == stamp [s]
    positions: np.ndarray  # (n, 2) [m]
    velocities: np.ndarray | None  # (n, 2) [m/s]; None where the path alone is given
    contacts: Contacts  # contacts and rebounds that this plan foresees
    aim: np.ndarray  # (2,) chosen intermediate position p_s [m]
    aim_velocity: np.ndarray  # (2,) chosen velocity v_s [m/s]
    terms: Mapping[str, float]
    """Cost terms of the choice by name (position, risk, collision_risk, gap_risk, velocity, total, ...)."""
    candidates: Candidates  # all candidates compared
    n_before_pruning: int  # number of candidates before pruning
    valid_until: float | None = None  # time until which it may be followed [s]; None where it has no such limit
    drive: tuple[float, float, float] | None = None
    """Largest acceleration [m/s^2], lag and delay [s] that it was made with; None where the parameters tell."""

    def __repr__(self) -> str:
        """Summary in a line: start, duration, length, number of contacts."""
        length = float(np.hypot(*np.diff(self.positions, axis=0).T).sum())
        lasts, touches = self.times[-1] - self.stamp, len(self.contacts.times)
        return f"Plan(from {self.stamp:g} s, {lasts:.2f} s, {length:.2f} m, {touches} contacts)"


def timed_path(
    stamp: float,
    times: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike | None = None,
    valid_until: float | None = None,
    contacts: Contacts | None = None,
) -> Plan:
    """Makes a plan from a path alone, as a planner of your own returns it; `valid_until` and `contacts` as in Plan.

    Args:
        stamp: when it starts [s].
        times: (n,) strictly rising, on the clock of the stamp, times[0] == stamp [s].
        positions: (n, 2) world frame [m].
        velocities: (n, 2) world frame [m/s]; at a contact, that after it. The controller finds those of a path alone.

    Raises:
        ValueError: another shape, n under 2, not finite, or times that do not rise.
    """
    path = rising("times", times)
    shape, form = (len(path), 2), f"expected finite x, y for each of {len(path)} times"
    where = finite("positions", positions, shape, form)
    how_fast = None if velocities is None else finite("velocities", velocities, shape, form)
    return plan_of_path(stamp, path, where, how_fast, valid_until, contacts)


def plan_of_path(
    stamp: float,
    times: np.ndarray,
    positions: np.ndarray,
    velocities: np.ndarray | None,
    valid_until: float | None = None,
    contacts: Contacts | None = None,
) -> Plan:
    """Makes a plan as `timed_path` does, from arrays that were checked already."""
    nothing = Candidates(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    touched = Contacts.none() if contacts is None else contacts
    aim, aim_velocity = positions[-1], np.zeros(2) if velocities is None else velocities[-1]
    return Plan(stamp, times, positions, velocities, touched, aim, aim_velocity, {}, nothing, 0, valid_until)


class NoPlan(RuntimeError):
    """Error of a cycle without a plan; the robot must stop. The message gives the reason."""

    def __init__(self, message: str, memory: Any = None) -> None:
        super().__init__(message)
        self.memory = memory  # memory that the cycle leaves to the next nevertheless; None where it is unchanged
