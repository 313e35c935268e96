"""Outcomes of a run, and the rule for a run that the planner does not end itself.

The planner reports by the status of the goal whether it was reached, given up or canceled.
"""

import math

import numpy as np

from collplan_core import goal
from collplan_core.command import HAND, STOPPED
from collplan_core.parameters import Settings, Trial

REACHED = "reached"
ABORTED = "aborted"
CANCELED = "canceled"
TIMEOUT = "timeout"
STUCK = "stuck"
OUTCOMES = {goal.SUCCEEDED: REACHED, goal.ABORTED: ABORTED, goal.CANCELED: CANCELED}
"""Outcome of a run by the final status of its goal."""


def drive_noise_hint(settings: Settings) -> str:
    """Part of a reason, after another one, where the simulated drive errs by half of v_max or more; else empty."""
    simulator = settings.simulator
    error = simulator.noise * math.hypot(simulator.actuation_noise, simulator.actuation_bias)
    if error < 0.5 * settings.robot.max_speed:
        return ""
    return (
        f"; simulator.noise: the drive errs by {error:.2g} m/s at robot.max_speed {settings.robot.max_speed:g} m/s,"
        " expected less than half of that"
    )


class RunMonitor:
    """Detects from the poses a run that takes too long or makes no progress; times are of a clock without steps [s].

    Attributes:
        reason: the reason why the run has ended; "" while it goes on.
    """

    def __init__(self, limits: Trial, given: float) -> None:
        """`given` is the time at which the goal was given [s]."""
        self.reason = ""
        self._limits = limits
        self._given = given
        self._begun: float | None = None
        self._anchor: np.ndarray | None = None
        self._anchored = given
        self._taken = False

    def executing(self, stamp: float) -> None:
        """Starts the count of time, at the goal's first plan [s]; later calls change nothing."""
        if self._begun is None:
            self._begun = stamp

    def commanded(self, maneuver: str) -> None:
        """Notes the newest maneuver: a robot driven by hand is not stuck until a plan drives it again."""
        if maneuver != STOPPED:
            self._taken = maneuver == HAND

    def outcome(self, stamp: float, position: np.ndarray) -> str | None:
        """TIMEOUT or STUCK, or None while the run goes on.

        TIMEOUT: trial.timeout has passed since the first plan. STUCK: the robot has stayed within trial.stuck_distance
        for trial.stuck_time since the first plan, and was not driven by hand; or trial.timeout has passed without
        a plan.

        Args:
            stamp: time of the newest pose [s].
            position: position of the newest pose (2,) [m].
        """
        limits = self._limits
        if self._begun is None:
            return (
                self._end(STUCK, f"no plan within {limits.timeout:g} s") if self._is_over(self._given, stamp) else None
            )
        if self._is_over(self._begun, stamp):
            return self._end(TIMEOUT, f"not there within {limits.timeout:g} s")
        if self._anchor is None or self._taken or math.dist(position, self._anchor) >= limits.stuck_distance:
            self._anchor, self._anchored = position, max(stamp, self._begun)
        if stamp - self._anchored >= limits.stuck_time:
            return self._end(STUCK, f"less than {limits.stuck_distance:g} m away within {limits.stuck_time:g} s")
        return None

    def _is_over(self, begun: float, stamp: float) -> bool:
        return stamp - begun >= self._limits.timeout

    def _end(self, outcome: str, reason: str) -> str:
        self.reason = reason
        return outcome
