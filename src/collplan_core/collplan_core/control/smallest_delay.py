"""The age of messages whose sender has another clock: the smallest delay seen counts as none."""

from dataclasses import dataclass
from math import inf

DRIFT = 1e-3
"""Rate by which the sender's clock may be slow [s/s]."""
STEP = 5.0
"""A delay longer than the smallest by more than this is a stepped clock, no message is under way for so long [s]."""


@dataclass(frozen=True)
class SmallestDelay:
    """The smallest delay of a stream of messages.

    Attributes:
        least: arrival less departure, each by its own clock [s]; inf before the first message.
        at: when it was last measured, by the receiver's clock [s].
    """

    least: float = inf
    at: float = 0.0

    def measured(self, sent: float, now: float) -> tuple["SmallestDelay", float]:
        """The delay after a message, and that message's age [s].

        After a step of the sender's clock the measurement begins anew; the message that shows the step is of unknown
        age, and counts as older than STEP where the clock was set back.

        Args:
            sent: departure by the sender's clock [s]; now: arrival by the receiver's [s], which never steps.
        """
        delay = now - sent
        raised = self.least + DRIFT * max(now - self.at, 0.0)
        if delay - raised > STEP:
            return SmallestDelay(delay, now), delay - raised
        least = min(raised, delay)
        return SmallestDelay(least, now), delay - least
