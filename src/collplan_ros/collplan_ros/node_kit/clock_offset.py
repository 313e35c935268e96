"""By how much a clock that can be set is ahead of one that cannot."""

from collections.abc import Callable

STEP = 0.01
"""Change between the two clocks beyond which one was set [s]."""
PROMPT = 0.001
"""Longest time for reading both clocks; what took longer compares them wrongly [s]."""
TRIES = 100
"""Readings of both clocks at first, until one is prompt."""


class ClockOffset:
    """Compares two clocks, and keeps to the last good comparison where this process was held up between two readings.

    Attributes:
        ahead: by how much the settable clock is ahead of the steady one [s].
    """

    def __init__(self, settable: Callable[[], float], steady: Callable[[], float]) -> None:
        """`settable` and `steady` are the two clocks [s]."""
        self._settable = settable
        self._steady = steady
        self.ahead, took = self._read()
        for _ in range(TRIES):
            if took <= PROMPT:
                break
            self.ahead, took = self._read()

    def compare(self) -> bool:
        """Reads both clocks; whether one was set since."""
        ahead, took = self._read()
        was_set = took <= PROMPT and abs(ahead - self.ahead) > STEP
        if was_set:
            self.ahead = ahead
        return was_set

    def _read(self) -> tuple[float, float]:
        before, settable, after = self._steady(), self._settable(), self._steady()
        return settable - after, after - before
