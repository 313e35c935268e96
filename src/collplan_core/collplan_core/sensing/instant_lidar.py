"""A LIDAR in a known world all of whose beams are of one instant: as in the paper exact, or with noise."""

from dataclasses import replace

import numpy as np

from collplan_core.parameters import Lidar
from collplan_core.scan import Scan
from collplan_core.sensing.mover_history import MoverHistory
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan

STREAM = 101
"""Key of the noise's stream among those of a seed; that of a spinning sensor is the one before."""


class InstantLidar:
    """Gives the scan at a pose; `lidar.range_noise` is added to each finite range."""

    def __init__(self, world: World, lidar: Lidar, seed: int, movers: MoverHistory | None = None) -> None:
        """Equal poses, movers and seeds give equal scans."""
        self._world, self._lidar, self._movers = world, lidar, movers or MoverHistory()
        self._random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(STREAM,)))

    def scan(self, state: State) -> Scan:
        """The scan from a pose (Scan), which it is stamped as.

        Raises:
            ValueError: the pose is not finite.
        """
        scan = simulate_scan(self._world, state, self._lidar, self._movers.at_each(np.array([state.stamp]))[0])
        if self._lidar.range_noise == 0.0:
            return scan
        errors = self._lidar.range_noise * self._random.standard_normal(len(scan.ranges))
        return replace(
            scan, ranges=np.where(np.isfinite(scan.ranges), np.maximum(scan.ranges + errors, 0.0), scan.ranges)
        )
