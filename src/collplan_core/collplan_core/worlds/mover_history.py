"""The last places of the movers in a simulated world, for the instant of each beam of a simulated LIDAR."""

from collections import deque

import numpy as np

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
