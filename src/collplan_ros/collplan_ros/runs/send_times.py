"""Times of sending, which the middleware gives by the wall clock, on the steady clock of this machine."""

import time
from collections import deque
from collections.abc import Callable, Sequence

from collplan_ros.node_kit.clock_offset import STEP, ClockOffset

KEPT = 8
"""Settings of the wall clock that are remembered: messages from before a step are still under way."""


class SendTimes:
    """Puts times of sending onto the steady clock, whatever steps the wall clock takes meanwhile."""

    def __init__(self, wall: Callable[[], float] = time.time, steady: Callable[[], float] = time.monotonic) -> None:
        """`wall` and `steady` are the two clocks [s]."""
        self._clock = steady
        self._offset = ClockOffset(wall, steady)
        self._settings = deque([self.ahead], maxlen=KEPT)

    @property
    def ahead(self) -> float:
        """By how much the wall clock is ahead of the steady clock now [s]."""
        return self._offset.ahead

    def now(self) -> float:
        """The present time [s, steady clock]."""
        return self._clock()

    def steady(self, sent: float) -> float:
        """When what was sent at `sent` [s, wall clock] was sent [s, steady clock].

        Of the settings that the wall clock has had, that one counts by which the message was on its way shortest, as
        none comes before it was sent.
        """
        if self._offset.compare():
            self._settings.append(self.ahead)
        now = self._clock()
        ages = [now - (sent - ahead) for ahead in self._settings]
        possible = [age for age in ages if age >= -STEP]
        return now - (min(possible) if possible else max(ages))


class ArrivalTimes:
    """Puts times at which messages came, by the wall clock, onto the steady clock, in the order in which they came."""

    def __init__(self, settings: Sequence[tuple[float, float]]) -> None:
        """`settings` of the wall clock, at least one: since when [s, steady clock], by how much it was ahead [s]."""
        self._settings = deque(settings)
        self._newest = settings[0][0]

    def steady(self, came: float) -> float:
        """When the next message came [s, steady clock], which by the wall clock was at `came` [s].

        One setting holds until by it a message would have come after the next one began, or before the last message.
        """
        while len(self._settings) > 1 and not self._newest - STEP <= came - self._settings[0][1] < self._settings[1][0]:
            self._settings.popleft()
        self._newest = came - self._settings[0][1]
        return self._newest
