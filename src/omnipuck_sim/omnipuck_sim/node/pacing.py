"""Simulated time and real time."""

STALL = 0.05
"""Time between two looks at the clock beyond which the simulator was held up; what is beyond counts [s]."""
SHORTEST_MEASUREMENT = 0.5
"""Real time over which the real-time factor is measured at least [s]."""


class Pacing:
    """The steps that keep a simulation in step with local time.

    `rate` counts steps per simulated second [Hz], `speed_factor` simulated seconds per second. `catch_up` is the
    simulated time made up for after a stall [s], more is given up; the first step begins at the local time `now` [s].
    """

    def __init__(self, rate: float, speed_factor: float, catch_up: float, now: float) -> None:
        self.behind = self.stalled = self.given_up = 0.0
        """Simulated time due without a step yet; time the simulator was held up; simulated time given up [s]."""
        self._rate = rate
        self._speed_factor = speed_factor
        self._catch_up = catch_up
        self._last = now

    def due(self, now: float) -> int:
        """Steps to take at the local time `now` [s]."""
        passed = max(now - self._last, 0.0)
        self._last = now
        self.stalled += max(passed - STALL, 0.0)
        self.behind += passed * self._speed_factor
        excess = max(self.behind - self._catch_up, 0.0)
        self.given_up += excess
        self.behind -= excess
        # a millionth of a step of tolerance: sums of decimal times must not decide
        steps = int(self.behind * self._rate + 1e-6)
        self.behind -= steps / self._rate
        return steps


class RealTimeFactor:
    """Simulated seconds per second, measured over a second or so."""

    def __init__(self, time: float, now: float) -> None:
        """Begins at the simulated `time` [s] and the local time `now` [s]."""
        self._begun = time, now
        self._factor = 1.0

    def measured(self, time: float, now: float) -> float:
        """The factor up to the simulated `time` [s] and the local time `now` [s]; the last one soon after it."""
        time_then, then = self._begun
        if time == time_then:  # it stood still
            self._begun = time, now
        elif now - then >= SHORTEST_MEASUREMENT:
            self._begun, self._factor = (time, now), (time - time_then) / (now - then)
        return self._factor
