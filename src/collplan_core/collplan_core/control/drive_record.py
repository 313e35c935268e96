"""Record of the commands to a robot and of its measured motion, one for each loop."""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.plane import rotate
from collplan_core.state import State

SPAN = 1.35
"""Time for which rows are kept [s]: no reader looks further back."""
BY_RECEIPT, BY_STAMP, OF_BODY = (0, 2, 3), (1, 2, 3), (1, 4, 5)
"""Columns of `told`: commands by either clock in the world frame, and by the poses' clock in the body frame."""


class DriveRecord(NamedTuple):
    """Recent commands and measured motion; what a reader has forgotten is only missing in its own `since`."""

    commands: np.ndarray = np.zeros((0, 6))
    """(n, 6) sent [s, local clock], [s, poses' clock], velocity [m/s, world frame], [m/s, body frame], times rising."""
    motion: np.ndarray = np.zeros((0, 7))  # (m, 7) receipt [s], stamp [s], velocity [m/s], position [m], yaw [rad]
    n_commands: int = 0  # n_commands, n_motion: number of rows that there ever were
    n_motion: int = 0

    def with_pose(self, state: State, local: float) -> "DriveRecord":
        """The record with a pose received at `local` [s, local clock]."""
        row = local, state.stamp, *state.velocity.tolist(), *state.position.tolist(), state.yaw
        return DriveRecord(self.commands, _with_row(self.motion, row), self.n_commands, self.n_motion + 1)

    def with_command(self, velocity: np.ndarray, local: float) -> "DriveRecord":
        """The record with a velocity (2,) [m/s, body frame] sent at `local` [s, local clock]; none before a pose."""
        if len(self.motion) == 0:
            return self
        received, stamp, *_, yaw = self.motion[-1].tolist()
        now, (x, y) = stamp + (local - received), velocity.tolist()
        # a pose that comes late sets the time on the poses' clock back a little
        now = max(now, float(self.commands[-1, 1])) if len(self.commands) else now
        row = local, now, *rotate(x, y, yaw), x, y
        return DriveRecord(_with_row(self.commands, row), self.motion, self.n_commands + 1, self.n_motion)

    def told(self, columns: tuple[int, int, int]) -> np.ndarray:
        """Commands (n, 3): time [s] and velocity [m/s], by BY_RECEIPT, BY_STAMP or OF_BODY."""
        return self.commands.take(columns, axis=1)

    def forgotten(self) -> "DriveRecord":
        """The record without rows, as after a break in the poses."""
        return self._replace(commands=self.commands[:0], motion=self.motion[:0])

    def since(self, before: "DriveRecord") -> "DriveRecord":
        """The rows from the first one of an earlier record on; where that has none, those added after it."""
        told = self.n_commands - before.n_commands + len(before.commands)
        moved = self.n_motion - before.n_motion + len(before.motion)
        if told >= len(self.commands) and moved >= len(self.motion):
            return self
        return self._replace(commands=_last(self.commands, told), motion=_last(self.motion, moved))


def _last(rows: np.ndarray, n: int) -> np.ndarray:
    return rows[max(len(rows) - n, 0) :]


@njit
def _with_row(rows: np.ndarray, row: tuple[float, ...]) -> np.ndarray:
    """The rows (n, k) with one more of k numbers, time first [s], without those older than SPAN."""
    # compiled, as it is called for each pose
    first = int(np.searchsorted(rows[:, 0], row[0] - SPAN))
    n = len(rows) - first
    kept = np.empty((n + 1, rows.shape[1]))
    kept[:n] = rows[first:]
    for k, value in enumerate(row):
        kept[n, k] = value
    return kept
