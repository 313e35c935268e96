"""Simulated time against real time."""

LONGEST_CATCH_UP = 0.05
"""Simulated time made up for at once after a stall of the simulator itself [s]; the rest is lost."""


class Pacing:
    """The steps that keep a simulation in step with local time.

    Args:
        rate: steps per simulated second [Hz].
        speed_factor: simulated seconds per second.
        now: local time at which the first step begins [s].
    """

    def __init__(self, rate: float, speed_factor: float, now: float) -> None:
        self._rate = rate
        self._speed_factor = speed_factor
        self._last = now
        self.ahead = 0.0
        """Simulated time that has passed since the last whole step [s]."""
        self.lost = 0.0
        """Simulated time given up in stalls [s]."""

    def due(self, now: float) -> int:
        """Steps to take at the local time `now` [s] to be where the simulation should be."""
        passed = self.ahead + max(now - self._last, 0.0) * self._speed_factor
        self._last = now
        kept = min(passed, LONGEST_CATCH_UP)
        self.lost += passed - kept
        steps = int(kept * self._rate)
        self.ahead = kept - steps / self._rate
        return steps
