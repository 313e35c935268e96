"""Whether a node's own steady timer had a gap: its process was frozen, or the machine stalled."""

import math


class StallGuard:
    """Tells a gap in the ticks of a timer.

    Attributes:
        gap: length of the newest gap beyond the limit [s]; 0 before the first.
        count: how many there were.
        ended: the tick that ended the newest one [s]; before all time where there was none.
    """

    def __init__(self, limit: float = 0.15) -> None:
        """A gap is a time between two ticks longer than `limit` [s]; the first tick ends none."""
        self.gap = 0.0
        self.count = 0
        self.ended = -math.inf
        self._limit = limit
        self._last: tuple[float, ...] = ()

    def tick(self, *now: float) -> bool:
        """Registers a tick; whether it ends a gap.

        Args:
            now: the time by a steady clock [s], and by others that may stand still meanwhile: a gap is one by all.
        """
        last, self._last = self._last, now
        gap = min((a - b for a, b in zip(now, last, strict=True)), default=0.0) if last else 0.0
        if gap <= self._limit:
            return False
        self.gap, self.count, self.ended = gap, self.count + 1, now[0]
        return True
