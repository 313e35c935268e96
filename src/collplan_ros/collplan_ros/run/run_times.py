"""The time of a run: the stamps of its poses, continued by the steady clock where they step."""

from collections.abc import Sequence

STEP = 3.0
"""Difference between stamps and steady clock beyond which the stamps' clock was set [s]; a robot whose poses stay away
for so long has ended its run."""
MOST = 100
"""Steps remembered."""


class RunTimes:
    """Continues the time of a run over steps of the clock that stamps its poses.

    Attributes:
        corrections: what was added to stamps so far [s]; the last one holds now.
    """

    def __init__(self, pace: float = 1.0) -> None:
        """`pace` is how many seconds of stamps pass in one of the steady clock; 0 where that varies."""
        self.corrections = [0.0]
        self._pace = pace
        self._last: tuple[float, float] | None = None

    def of_pose(self, stamp: float, sent: float) -> float:
        """Time [s] of the next pose, from its stamp [s] and when it was sent [s, steady clock]."""
        time = stamp + self.corrections[-1]
        if self._last is not None:
            last, last_sent = self._last
            expected = last + self._pace * max(0.0, sent - last_sent)
            if time < last or (self._pace and abs(time - expected) > self._pace * STEP):
                self.corrections = [*self.corrections[-MOST:], expected - stamp]
                time = expected
        self._last = time, sent
        return time


def continued(stamp: float, near: float, corrections: Sequence[float]) -> float:
    """Time [s] of a stamp [s] of another message, by that correction which puts it nearest to the time `near` [s]."""
    return min((stamp + correction for correction in corrections), key=lambda time: abs(time - near))
