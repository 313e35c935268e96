"""How old a message is, by the clock of whoever sent it."""

import math

from collplan_core.control.smallest_delay import SmallestDelay

SILENCE = 1.0
"""After a longer silence another one may send, by another clock [s]."""


class SenderAge:
    """The age of each message of a stream; the smallest delay seen counts as none, so that clocks may differ."""

    def __init__(self, limit: float) -> None:
        """A message that seems older than `limit` [s] after a SILENCE is the first one of another sender."""
        self._limit = limit
        self._delay = SmallestDelay()

    def measured(self, sent: float, now: float) -> float:
        """The age of a message [s]; infinite for the first one of a sender, whose age is not known.

        Args:
            sent: departure by the sender's clock [s]; now: arrival by a steady one [s].
        """
        before = self._delay
        self._delay, age = before.measured(sent, now)
        if math.isinf(before.least):
            return math.inf
        if now - before.at > SILENCE and age > self._limit:
            self._delay, _ = SmallestDelay().measured(sent, now)
            return math.inf
        return age
