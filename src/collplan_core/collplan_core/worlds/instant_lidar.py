"""A LIDAR in a known world all of whose beams are of one instant: as in the paper exact, or with noise."""

from dataclasses import replace

import numpy as np

from collplan_core.parameters import Lidar
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.mover_history import MoverHistory
from collplan_core.worlds.raycast import simulate_scan
from collplan_core.worlds.scan_faults import published, returned

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
