"""Times of sending, which the middleware gives by the wall clock, on the steady clock of this machine."""

import time
from collections import deque
from collections.abc import Callable

from collplan_ros.node_kit.clock_offset import STEP, ClockOffset

KEPT = 8
"""Settings of the wall clock that are remembered: messages from before a step are still under way."""


class SendTimes:
    """Puts times of sending onto the steady clock, whatever steps the wall clock takes meanwhile.

    Attributes:
        ahead_at_first: by how much the wall clock was ahead of the steady clock at first [ns].
    """

    def __init__(self, wall: Callable[[], float] = time.time, steady: Callable[[], float] = time.monotonic) -> None:
        """`wall` and `steady` are the two clocks [s]."""
        self._clock = steady
        self._offset = ClockOffset(wall, steady)
        self._settings = deque([self.ahead], maxlen=KEPT)
        self.ahead_at_first = round(1e9 * self.ahead)

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
