"""Ages of messages by clocks that may differ from the sender's, and gaps in the receiver's own ticks."""

import math
from dataclasses import dataclass

DRIFT = 1e-3
"""Rate by which the sender's clock may be slow [s/s]."""
STEP = 5.0
"""A delay longer than the smallest by more than this is a stepped clock, no message is under way for so long [s]."""
SILENCE = 1.0
"""After a longer silence another one may send, by another clock [s]."""


@dataclass(frozen=True)
class SmallestDelay:
    """The smallest delay of a stream of messages whose sender has another clock; it counts as none."""

    least: float = math.inf  # arrival less departure, each by its own clock [s]; inf before the first message
    at: float = 0.0  # time of its last measurement, by the receiver's clock [s]

    def measured(self, sent: float, now: float) -> tuple["SmallestDelay", float]:
        """The delay after a message, and that message's age [s].

        After a step of the sender's clock the measurement begins anew; the message that shows the step is of unknown
        age, and counts as older than STEP where the clock was set back. Departure is by the sender's clock [s], arrival
        by the receiver's [s], which never steps.
        """
        delay = now - sent
        raised = self.least + DRIFT * max(now - self.at, 0.0)
        if delay - raised > STEP:
            return SmallestDelay(delay, now), delay - raised
        least = min(raised, delay)
        return SmallestDelay(least, now), delay - least


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


class PosesClock:
    """Estimate of the time on the poses' clock: stamp of the newest pose + local time since it was received.

    The clock of a motion-capture computer may be seconds off; it is never compared with the local one.
    """

    def __init__(self) -> None:
        self._stamp: float | None = None
        self._local = 0.0

    def received(self, stamp: float, local: float) -> None:
        """Registers a pose with this stamp [s, poses' clock], received at `local` [s, local clock]."""
        self._stamp, self._local = stamp, local

    def now(self, local: float) -> float | None:
        """The time on the poses' clock [s]; None before the first pose."""
        return None if self._stamp is None else self._stamp + (local - self._local)

    def age(self, local: float) -> float:
        """Local time since the newest pose was received [s]; infinite before the first."""
        return math.inf if self._stamp is None else local - self._local


class StallGuard:
    """Tells a gap in the ticks of a timer."""

    def __init__(self, limit: float = 0.15) -> None:
        """A gap is a time between two ticks longer than `limit` [s]; the first tick ends none."""
        self.gap = 0.0  # length of the newest gap beyond the limit [s]; 0 before the first
        self.count = 0  # number of gaps
        self.ended = -math.inf  # the tick that ended the newest one [s]; before all time where there was none
        self._limit = limit
        self._last = math.inf

    def tick(self, now: float) -> bool:
        """Registers a tick at `now` [s]; returns whether it ends a gap."""
        last, self._last = self._last, now
        gap = now - last
        if gap <= self._limit:
            return False
        self.gap, self.count, self.ended = gap, self.count + 1, now
        return True
