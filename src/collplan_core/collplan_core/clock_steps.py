"""Times by clocks that may be set while a run goes on."""

import time
from collections import deque
from collections.abc import Callable

STEP = 0.01
"""Change between the two clocks beyond which one was set [s]."""
PROMPT = 0.001
"""Longest time for reading both clocks; what took longer compares them wrongly [s]."""
TRIES = 100
"""Readings of both clocks at first, until one is prompt."""
KEPT = 8
"""Settings of the wall clock that are remembered: messages from before a step are still under way."""
POSES_STEP = 3.0
"""Difference between stamps and steady clock beyond which the stamps' clock was set [s]; a robot whose poses stay away
for so long has ended its run."""
MOST = 100
"""Steps remembered."""


class ClockOffset:
    """Compares two clocks; keeps to the last good comparison where this process was held up between two readings."""

    def __init__(self, settable: Callable[[], float], steady: Callable[[], float]) -> None:
        """`settable` and `steady` are the two clocks [s]."""
        self._settable = settable
        self._steady = steady
        self.ahead, took = self._read()  # time by which the settable clock is ahead of the steady one [s]
        for _ in range(TRIES):
            if took <= PROMPT:
                break
            self.ahead, took = self._read()

    def compare(self) -> bool:
        """Reads both clocks; returns whether one was set since."""
        ahead, took = self._read()
        was_set = took <= PROMPT and abs(ahead - self.ahead) > STEP
        if was_set:
            self.ahead = ahead
        return was_set

    def _read(self) -> tuple[float, float]:
        before, settable, after = self._steady(), self._settable(), self._steady()
        return settable - after, after - before


class SendTimes:
    """Puts times of sending onto the steady clock, whatever steps the wall clock takes meanwhile."""

    def __init__(self, wall: Callable[[], float] = time.time, steady: Callable[[], float] = time.monotonic) -> None:
        """`wall` and `steady` are the two clocks [s]."""
        self._clock = steady
        self._offset = ClockOffset(wall, steady)
        self._settings = deque([self.ahead], maxlen=KEPT)
        self.ahead_at_first = round(1e9 * self.ahead)
        """Time by which the wall clock was ahead of the steady clock at first [ns]."""

    @property
    def ahead(self) -> float:
        """Time by which the wall clock is ahead of the steady clock now [s]."""
        return self._offset.ahead

    def now(self) -> float:
        """The present time [s, steady clock]."""
        return self._clock()

    def steady(self, sent: float) -> float:
        """Returns the time on the steady clock [s] of a message sent at `sent` [s, wall clock].

        Of the settings that the wall clock has had, the one that gives the shortest transport time counts, as no
        message arrives before it was sent.
        """
        if self._offset.compare():
            self._settings.append(self.ahead)
        now = self._clock()
        ages = [now - (sent - ahead) for ahead in self._settings]
        possible = [age for age in ages if age >= -STEP]
        return now - (min(possible) if possible else max(ages))


class RunTimes:
    """Continues the time of a run over steps of the clock that stamps its poses."""

    def __init__(self, pace: float = 1.0) -> None:
        """`pace` is how many seconds of stamps pass in one of the steady clock; 0 where that varies."""
        self._corrections = [0.0]
        self._pace = pace
        self._last: tuple[float, float] | None = None

    def of_pose(self, stamp: float, sent: float) -> float:
        """Time [s] of the next pose, from its stamp [s] and when it was sent [s, steady clock]."""
        time = stamp + self._corrections[-1]
        if self._last is not None:
            last, last_sent = self._last
            expected = last + self._pace * max(0.0, sent - last_sent)
            if time < last or (self._pace and abs(time - expected) > self._pace * POSES_STEP):
                self._corrections = [*self._corrections[-MOST:], expected - stamp]
                time = expected
        self._last = time, sent
        return time

    def of(self, stamp: float) -> float:
        """Time [s] of the stamp [s] of another message: by the correction that puts it nearest to the last pose."""
        near = stamp if self._last is None else self._last[0]
        return min((stamp + correction for correction in self._corrections), key=lambda time: abs(time - near))
