"""Poses of a robot that was driven, the ranges of its LIDAR meanwhile, and the pairs of scans that tell most."""

from dataclasses import dataclass

import numpy as np

SOONEST, LATEST = 0.3, 1.2
"""Times between the two scans of a pair [s]: later the odometry drifts and the room is another one."""
EDGE = 0.6
"""Time at either end of the poses within which no scan is paired [s]: its stamp may be so wrong."""
FEWEST_HITS = 30
LEAST_TURN, LEAST_WAY = 0.1, 0.06
"""Motion within a pair from which on it tells anything: of turning [rad], and of driving [m]."""
MOST = 40
"""Pairs that turn, and pairs that go, that are compared at most."""


@dataclass(frozen=True, eq=False)
class Driven:
    """A drive as arrays."""

    times: np.ndarray  # (n,) of the poses, rising [s]
    poses: np.ndarray  # (n, 3) x, y [m] and yaw, not wrapped [rad]
    stamps: np.ndarray  # (m,) of the scans, as their messages give them [s]
    ranges: np.ndarray  # (m, k) [m], NaN where nothing was met
    angles: np.ndarray  # (k,) of the beams, as the messages count them [rad]
    between: float  # time from beam to beam [s]; 0 where all are of one instant


@dataclass(frozen=True, eq=False)
class Pairs:
    """Pairs of scans between which the robot moved."""

    scans: np.ndarray  # (p, 2) int, of the earlier and of the later scan
    turned: np.ndarray  # turned, went: (p,) how far between them [rad], [m]
    went: np.ndarray

    @property
    def shows_turns(self) -> bool:
        """Whether enough pairs turn: only a turn shows the LIDAR's place and stamp."""
        return int((self.turned > LEAST_TURN).sum()) >= MOST // 4

    @property
    def shows_ways(self) -> bool:
        """Whether the robot drives far enough in enough pairs: only that shows the LIDAR's heading."""
        return int((self.went > LEAST_WAY).sum()) >= MOST // 4


def pairs_of(driven: Driven) -> Pairs:
    """The pairs that turn most, and as many that go farthest; empty where the robot stood."""
    stamps = driven.stamps
    usable = (np.isfinite(driven.ranges).sum(axis=1) >= FEWEST_HITS) & (stamps > driven.times[0] + EDGE)
    first = np.flatnonzero(usable & (stamps < driven.times[-1] - EDGE))
    partner = (
        first[np.minimum(stamps[first].searchsorted(stamps[first] + SOONEST), len(first) - 1)] if len(first) else first
    )
    apart = stamps[partner] - stamps[first]
    near = (apart >= SOONEST) & (apart <= LATEST)
    scans = np.column_stack([first[near], partner[near]])
    at = np.column_stack([np.interp(stamps, driven.times, column) for column in driven.poses.T])
    change = at[scans[:, 1]] - at[scans[:, 0]]
    turned, went = np.abs(change[:, 2]), np.hypot(change[:, 0], change[:, 1])
    chosen = np.union1d(_most(turned, LEAST_TURN), _most(went, LEAST_WAY)).astype(int)
    return Pairs(scans[chosen], turned[chosen], went[chosen])


def _most(moved: np.ndarray, least: float) -> np.ndarray:
    """Indices of pairs that moved more than `least`, of the half that moved most, evenly over the time."""
    enough = np.flatnonzero(moved > least)
    far = np.sort(enough[np.argsort(-moved[enough], kind="stable")][: max(MOST, len(enough) // 2)])
    return far[np.linspace(0, len(far) - 1, min(MOST, len(far))).astype(int)] if len(far) else far
