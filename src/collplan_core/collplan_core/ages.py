"""Ages of messages by clocks that may differ from the sender's, and gaps in the receiver's own ticks."""

import math
from dataclasses import dataclass

DRIFT = 1e-3
"""Rate by which the sender's clock may be slow [s/s]."""
STEP = 5.0
"""A delay longer than the smallest by more than this is a stepped clock, no message is under way for so long [s]."""
SILENCE = 1.0
"""After a longer silence another one may send, by another clock [s]."""
CATCHES_UP = 0.3
"""Rate at which poses that stay late count as in time again: their clock was set back [s/s]."""
CLOCK = "clock"
"""Kind of a refusal beside accepted poses, whose stamps do not run as time does."""
CLOCK_RATIO = 1.5
"""Stamps that run faster or slower than this multiple of the local time cannot be seconds."""
SLOWEST = 50.0
"""Stamps that are slower than this are not of a simulation, but in another unit."""


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
        self._least_delay = math.inf
        self.late = 0.0  # time by which the newest pose is later than the others [s]

    def received(self, stamp: float, local: float, joins: bool = True) -> None:
        """Registers a pose with this stamp [s, poses' clock], received at `local` [s, local clock].

        One that does not join the one before, as where the robot was carried, is in time.
        """
        delay = local - stamp
        before = self._least_delay + CATCHES_UP * (local - self._local) if joins else math.inf
        self._least_delay = min(delay, before)
        self.late = delay - self._least_delay
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


def why_clock_is_wrong(stamps: float, elapsed: float) -> str:
    """Returns why stamps that advance by `stamps` [s] in `elapsed` [s] are wrong; empty if they are not."""
    if math.isnan(elapsed) or elapsed / CLOCK_RATIO < stamps < elapsed * CLOCK_RATIO:
        return ""
    what = "in which unit are those of header.stamp?"
    if elapsed / SLOWEST < stamps < elapsed:
        what = f"a simulation? then use_sim_time: true for every node; else {what}"
    return f"{stamps:.3g} s of stamps in {elapsed:.2f} s, expected as many: {what}"
