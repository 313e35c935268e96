"""Timing of the graph in the last seconds."""

from collections import deque

from collplan_core.evaluation.run_end import Timing

RECENT = 10.0
"""Age beyond which figures are no longer shown [s]."""


class RecentTiming:
    """Takes figures that show whether the machine is fast enough; times are of one steady clock [s]."""

    def __init__(self) -> None:
        self._factors: deque[tuple[float, float]] = deque()
        self._gaps: deque[tuple[float, float]] = deque()

    def commanded(self, period: float, now: float) -> None:
        """Takes the time between two commands [s]."""
        self._gaps.append((now, period))

    def reported(self, factor: float, now: float) -> None:
        """Takes the simulated seconds in the last second."""
        self._factors.append((now, factor))

    def newest_factor(self, now: float) -> float | None:
        """Simulated seconds in the last second that was reported; None where none was."""
        self._forget(now)
        return self._factors[-1][1] if self._factors else None

    def timing(self, now: float) -> Timing:
        """The timing of the last seconds."""
        self._forget(now)
        factors = [factor for _, factor in self._factors]
        longest = max((gap for _, gap in self._gaps), default=0.0)
        return Timing(sum(factors) / len(factors) if factors else None, longest)

    def _forget(self, now: float) -> None:
        for rows in (self._factors, self._gaps):
            while rows and rows[0][0] < now - RECENT:
                rows.popleft()
