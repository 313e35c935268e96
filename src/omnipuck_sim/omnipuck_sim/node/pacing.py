"""Simulated time against real time."""

import math

STALL = 0.05
"""Time between two looks at the clock beyond which the simulator was held up; what is beyond counts [s]."""
AT_ONCE = 0.01
"""Simulated time that passes between two looks at the clock where the graph alone sets the pace [s]."""


class Pacing:
    """The steps that keep a simulation in step with local time, or with the graph.

    Args:
        rate: steps per simulated second [Hz].
        speed_factor: simulated seconds per second; 0 for as many as the graph allows.
        catch_up: simulated time that is made up for after a stall [s]; more is given up.
        now: local time at which the first step begins [s].

    Attributes:
        behind: simulated time that has passed by the clock, and for which no step was taken yet [s].
        stalled: time for which the simulator itself was held up so far [s].
        given_up: simulated time given up so far [s].
    """

    def __init__(self, rate: float, speed_factor: float, catch_up: float, now: float) -> None:
        self.behind = self.stalled = self.given_up = 0.0
        self._rate = rate
        self._speed_factor = speed_factor
        self._catch_up = catch_up
        self._last = now

    def due(self, now: float, allowed: float = math.inf) -> int:
        """Steps to take at the local time `now` [s].

        Args:
            now: local time [s].
            allowed: simulated time that may pass before the graph must be waited for [s]; infinite where none is.
        """
        passed = max(now - self._last, 0.0)
        self._last = now
        self.stalled += max(passed - STALL, 0.0)
        if self._speed_factor == 0.0 and math.isfinite(allowed):
            self.behind = AT_ONCE
        else:
            self.behind += passed * (self._speed_factor or 1.0)
        excess = max(self.behind - self._catch_up, 0.0)
        self.given_up += excess
        self.behind -= excess
        # a millionth of a step of tolerance: sums of decimal times must not decide
        steps = max(int(min(self.behind, allowed) * self._rate + 1e-6), 0)
        self.behind -= steps / self._rate
        return steps
