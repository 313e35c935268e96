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
        self._last: float | None = None

    def tick(self, now: float) -> bool:
        """Registers a tick at `now` [s, a steady clock]; whether it ends a gap."""
        last, self._last = self._last, now
        if last is None or now - last <= self._limit:
            return False
        self.gap, self.count, self.ended = now - last, self.count + 1, now
        return True
