"""A LIDAR in a known world all of whose beams are of one instant: as in the paper exact, or with noise."""

import math
from collections import deque
from dataclasses import replace

import numpy as np

from collplan_core.parameters import Lidar
from collplan_core.scan import Scan
from collplan_core.sight_lines import is_full_turn
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan

HELD = 1.0
"""Span of the places kept [s]."""


class MoverHistory:
    """Keeps the movers' discs of the last HELD seconds by their stamps; until the first come, there are none."""

    def __init__(self) -> None:
        self._kept: deque[tuple[float, np.ndarray]] = deque()

    def add(self, stamp: float, discs: np.ndarray) -> None:
        """Adds the newest discs (k, 3) x, y, radius [m]; after a clock was set back, or with another k, begins anew."""
        if self._kept and (stamp <= self._kept[-1][0] or discs.shape != self._kept[-1][1].shape):
            self._kept.clear()
        self._kept.append((stamp, discs))
        while self._kept[0][0] < stamp - HELD:
            self._kept.popleft()

    def at_each(self, times: np.ndarray) -> np.ndarray:
        """(n, k, 3) the discs at times (n,) [s]: between those kept, and the first or last of them beyond."""
        if not self._kept or not self._kept[-1][1].size:
            return np.zeros((len(times), 0, 3))
        stamps, discs = zip(*self._kept, strict=True)
        columns = np.reshape(discs, (len(discs), -1)).T
        return np.column_stack([np.interp(times, stamps, each) for each in columns]).reshape(len(times), -1, 3)


FLATTEST = math.radians(10.0)
"""Angle between a beam and a surface below which nothing comes back [rad]."""
RENEWED = 0.15
"""Period of the sensor that a driver polls more often [s]."""


def returned(ranges: np.ndarray, increment: float, fault: str) -> np.ndarray:
    """(n,) exact ranges (n,) [m] of beams `increment` [rad] apart, with `flat` +Inf where a surface is met flatly."""
    if fault != "flat":
        return ranges
    finite = np.where(np.isfinite(ranges), ranges, 0.0)
    rises = np.diff(finite, append=finite[0] if is_full_turn(len(ranges), increment) else finite[-1])
    steep = np.where(np.abs(rises) * math.tan(FLATTEST) > finite * abs(increment), np.sign(rises), 0.0)
    # at an edge one step alone is as large
    return np.where((steep != 0.0) & (steep == np.roll(steep, 1)), np.inf, ranges)


def published(scan: Scan, before: Scan | None, fault: str) -> Scan:
    """The scan as a driver gives it, which gave `before` last."""
    if fault == "zeros":
        # a scan keeps a 0 as it is only where no range is too near
        return replace(scan, range_min=0.0, ranges=np.where(np.isfinite(scan.ranges), scan.ranges, 0.0))
    if fault == "repeats" and before is not None and scan.stamp // RENEWED == before.stamp // RENEWED:
        return replace(scan, ranges=before.ranges)
    return scan


STREAM = 101
"""Key of the noise's stream among those of a seed; that of a spinning sensor is the one before."""


class InstantLidar:
    """Gives the scan at a pose; `lidar.range_noise` is added to each finite range."""

    def __init__(self, world: World, lidar: Lidar, seed: int, movers: MoverHistory | None = None) -> None:
        """Equal poses, movers and seeds give equal scans."""
        self._world, self._lidar, self._movers = world, lidar, movers or MoverHistory()
        self._last: Scan | None = None
        self._random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(STREAM,)))

    def scan(self, state: State) -> Scan:
        """The scan from a pose (Scan), stamped as the pose, but for `lidar.stamp_offset`.

        Raises:
            ValueError: the pose is not finite.
        """
        lidar = self._lidar
        scan = simulate_scan(self._world, state, lidar, self._movers.at_each(np.array([state.stamp]))[0])
        if lidar.range_noise == lidar.stamp_offset == 0.0 and lidar.fault == "none":
            return scan
        ranges = returned(scan.ranges, scan.angle_increment, lidar.fault)
        if lidar.range_noise > 0.0:
            errors = lidar.range_noise * self._random.standard_normal(len(ranges))
            ranges = np.where(np.isfinite(ranges), np.maximum(ranges + errors, 0.0), ranges)
        scan = replace(scan, stamp=scan.stamp - lidar.stamp_offset, ranges=ranges)
        self._last = published(scan, self._last, lidar.fault)
        return self._last
