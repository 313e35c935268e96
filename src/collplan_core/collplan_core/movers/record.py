"""The bodies that move around the robot, as discs, and what each of them can reach."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np


@dataclass(frozen=True, eq=False)
class Movers:
    """Discs that move, as the scans up to `stamp` show them, world frame; a person is the discs of two legs."""

    stamp: float  # stamp of the newest of these scans [s]
    numbers: np.ndarray
    """(k,) number of the mover that each is a part of, the same in every scan; the legs of a person have one."""
    positions: np.ndarray  # (k, 2) of their centres at the stamp [m]
    velocities: np.ndarray  # (k, 2) [m/s]
    radii: np.ndarray  # (k,) [m]
    growths: np.ndarray  # (k,) how fast each may leave its predicted way [m/s]
    seen: np.ndarray  # (k,) stamp of the last scan that shows it [s]

    def __len__(self) -> int:
        """Number of discs."""
        return len(self.radii)

    @cached_property
    def rows(self) -> np.ndarray:
        """(k, 6) x, y [m], vx, vy [m/s], radius [m] and growth [m/s] at the stamp, for compiled code.

        The radius is that of the place that each can be in since it was seen.
        """
        reached = self.radii + self.growths * (self.stamp - self.seen)
        return np.column_stack([self.positions, self.velocities, reached, self.growths])

    @property
    def whole(self) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (m,) of whole movers, and (m, 5) x, y, vx, vy, radius of the disc that holds all parts of each."""
        numbers, rows = np.unique(self.numbers), list[np.ndarray]()
        for number in numbers:
            of = self.numbers == number
            middle = self.positions[of].mean(axis=0)
            radius = (np.hypot(*(self.positions[of] - middle).T) + self.radii[of]).max()
            rows.append(np.array([*middle, *self.velocities[of].mean(axis=0), radius]))
        return numbers, np.array(rows).reshape(-1, 5)

    def rows_at(self, now: float) -> np.ndarray:
        """(k, 6) the same at another time `now` [s], predicted at constant velocity."""
        rows, later = self.rows.copy(), now - self.stamp
        rows[:, :2] += later * rows[:, 2:4]
        rows[:, 4] += abs(later) * rows[:, 5]
        return rows


NEW, STANDS, MOVES = 0, 1, 2
"""Kinds of a return."""


@dataclass(frozen=True, eq=False)
class SortedReturns:
    """The returns of a scan by kind, and what moves."""

    kinds: np.ndarray
    """(n,) of the n beams in the order of the scan's surfaces, NEW without a hit; (0,) where all stand."""
    movers: Movers  # what moves
    swept: np.ndarray  # (m, 3) discs x, y, radius [m] that these movers have just been in
    trails: np.ndarray  # (h, 3) discs along the ways on which they came [m]


NO_MOVERS = Movers(-np.inf, np.zeros(0, int), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0))
ALL_STANDS = SortedReturns(np.zeros(0, int), NO_MOVERS, np.zeros((0, 3)), np.zeros((0, 3)))
"""Sorted returns of a scan in which everything stands."""


@dataclass(frozen=True, eq=False)
class Unseen:
    """Places around the robot that the newest scan has out of view, and no earlier one saw."""

    stamp: float = -math.inf  # stamp of that scan [s]
    places: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    """(k, 2) middles of these cells, within coverage.REACH [m]."""
    edges: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    """(e, 2) those of them that lie beside a place seen to be free [m]."""
    blind: float = 0.0  # angle that the scan leaves out, all gaps wide enough together [rad]
    faces: float = math.nan
    """Direction opposite to the middle of the widest gap, seen from the robot [rad]; NaN without a gap."""


ALL_SEEN = Unseen()
