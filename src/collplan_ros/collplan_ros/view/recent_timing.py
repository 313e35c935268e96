"""Timing of the graph in the last seconds."""

from collections import deque

from collplan_core.evaluation.machine import Timing
from collplan_ros.messages.lockstep_report import LockstepReport

RECENT = 10.0
"""Age beyond which figures are no longer shown [s]."""


class RecentTiming:
    """Takes figures that show whether the machine is fast enough; times are of one steady clock [s]."""

    def __init__(self) -> None:
        self._factors: deque[tuple[float, float]] = deque()
        self._gaps: deque[tuple[float, float, str]] = deque()
        self._longest_wait: float | None = None

    def commanded(self, period: float, now: float) -> None:
        """Takes the time between two commands [s]."""
        self._gaps.append((now, period, ""))

    def reported(self, lockstep: LockstepReport, now: float) -> None:
        """Takes a report of simulator_node; waits before the first report are of an earlier time."""
        self._factors.append((now, lockstep.factor))
        if self._longest_wait is not None and lockstep.longest_wait > self._longest_wait:
            self._gaps.append((now, lockstep.longest_wait, lockstep.waited_for))
        self._longest_wait = lockstep.longest_wait

    def newest_factor(self, now: float) -> float | None:
        """Simulated seconds in the last second that was reported; None where none was."""
        self._forget(now)
        return self._factors[-1][1] if self._factors else None

    def timing(self, now: float) -> Timing:
        """Returns the timing of the last seconds; a wait for a node replaces the gap that it causes."""
        self._forget(now)
        factors = [factor for _, factor in self._factors]
        _, gap, waited_for = max(self._gaps, key=lambda each: (bool(each[2]), each[1]), default=(now, 0.0, ""))
        return Timing(sum(factors) / len(factors) if factors else None, gap, waited_for)

    def _forget(self, now: float) -> None:
        for rows in (self._factors, self._gaps):
            while rows and rows[0][0] < now - RECENT:
                rows.popleft()
