"""The last places of the movers in a simulated world, for the instant of each beam of a simulated LIDAR."""

from collections import deque

import numpy as np

HELD = 1.0
"""Span of the places kept [s]."""


class MoverHistory:
    """Keeps the movers' discs of the last HELD seconds by their stamps; until the first come, there are none."""

    def __init__(self) -> None:
        self._stamps: deque[float] = deque()
        self._discs: deque[np.ndarray] = deque()

    def add(self, stamp: float, discs: np.ndarray) -> None:
        """Adds the newest discs (k, 3) x, y, radius [m]; after a clock was set back, or with another k, begins anew."""
        if self._stamps and (stamp <= self._stamps[-1] or discs.shape != self._discs[-1].shape):
            self._stamps.clear()
            self._discs.clear()
        self._stamps.append(stamp)
        self._discs.append(discs)
        while self._stamps[0] < stamp - HELD:
            self._stamps.popleft()
            self._discs.popleft()

    def at_each(self, times: np.ndarray) -> np.ndarray:
        """(n, k, 3) the discs at times (n,) [s]: between those kept, and the first or last of them beyond."""
        if not self._discs or not self._discs[-1].size:
            return np.zeros((len(times), 0, 3))
        columns = np.array(self._discs).reshape(len(self._discs), -1).T
        return np.column_stack([np.interp(times, self._stamps, column) for column in columns]).reshape(
            len(times), -1, 3
        )
