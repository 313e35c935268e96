"""The simulated time of past moments of the system's clock."""

import time
from bisect import bisect_right
from collections import deque

from omnipuck_sim.robot.physics import Simulator

KEPT = 500
"""Moments that are remembered."""


class SimulatedTimes:
    """The simulated time, which passes in leaps, for the ages of messages."""

    def __init__(self, simulator: Simulator) -> None:
        self._simulator = simulator
        self._leaps: deque[tuple[float, float]] = deque(maxlen=KEPT)

    def leapt(self) -> None:
        """Notes that the simulated time has passed."""
        self._leaps.append((time.time(), self._simulator.time))

    def now(self) -> float:
        """The simulated time [s]."""
        return self._simulator.time

    def sent(self, wall: float) -> float:
        """The simulated time [s] at `wall` [s, system's clock]; the earliest one known, for a moment before it."""
        following = bisect_right(self._leaps, wall, key=lambda leap: leap[0])
        return self._leaps[max(following - 1, 0)][1] if self._leaps else 0.0
