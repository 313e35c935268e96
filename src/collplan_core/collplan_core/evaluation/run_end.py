"""The end of a run: its outcome, the length of its path, and whether the machine was fast enough for a real robot."""

import math
from dataclasses import dataclass

import numpy as np

from collplan_core import goal
from collplan_core.command import HAND, STOPPED, WAITING
from collplan_core.parameters import Settings, Trial

ABOUT = 0.05
"""Share by which simulated time may run slower than it should and still count as on time."""

ACTUATION_NOISE, ACTUATION_BIAS = 0.06, 0.03
"""Noise per command period and bias of a run of the simulated drive, standard deviations by axis, at level 1 [m/s]."""


@dataclass(frozen=True)
class Timing:
    """The real-time factor and the longest gap of a graph."""

    factor: float | None = None
    """Simulated seconds that passed in a second; None where it is not known, or the robot is not simulated."""
    gap: float = 0.0  # longest time between two commands [s, wall clock]


def pace_words(factor: float | None) -> str:
    """Returns the real-time factor as "0.85x real time"; empty where it is unknown or about 1."""
    return "" if factor is None or abs(factor - 1.0) <= ABOUT else f"{factor:.2f}x real time"


def machine_verdict(timing: Timing, speed_factor: float, command_age: float) -> str:
    """Returns a sentence that the machine is too slow for a real robot; empty where all kept up, or no clock paced it.

    A simulation that is wanted slower than real time may be slow by as much.

    Args:
        speed_factor: simulated seconds wanted in a second; 0 where time waits for the nodes.
        command_age: age at which a robot follows its last command no more [s].
    """
    wanted = min(speed_factor, 1.0)
    is_slow = timing.factor is not None and timing.factor < (1.0 - ABOUT) * wanted
    if not wanted or (not is_slow and timing.gap <= command_age / wanted):
        return ""
    found = [f"simulated time ran at {timing.factor:.2f} of real time"] if is_slow else []
    if timing.gap:
        found.append(f"longest gap between two commands {timing.gap:.2f} s")
    return f"this machine is too slow for a real robot, or busy: {', '.join(found)}"


CUTOFF = 5.0
"""Noise above this frequency is taken out of measured poses [Hz]."""
FILTER_RATE = 100.0
"""Rate at which measured poses are filtered [Hz]."""
SAMPLE_RATE = 20.0
"""Rate at which filtered poses are summed [Hz]."""


def path_length(positions: np.ndarray) -> float:
    """Length of the polyline through exact positions (n, 2) [m]."""
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())


def measured_path_length(times: np.ndarray, positions: np.ndarray) -> float:
    """Length of the path behind noisy positions (n, 2) at rising times (n,) [m].

    Low-passed at CUTOFF without delay and resampled at SAMPLE_RATE: summed as they are, 2 mm of noise at 100 Hz would
    add some percent. A path of less than one period of CUTOFF is only resampled.
    """
    if len(times) < 2:
        return 0.0
    even = _even_times(times, FILTER_RATE)
    smooth = _low_passed(_at(even, times, positions))
    return path_length(_at(_even_times(times, SAMPLE_RATE), even, smooth))


def _even_times(times: np.ndarray, rate: float) -> np.ndarray:
    return np.linspace(times[0], times[-1], max(2, round((times[-1] - times[0]) * rate) + 1))


def _at(wanted: np.ndarray, times: np.ndarray, positions: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(wanted, times, positions[:, axis]) for axis in (0, 1)])


def _low_passed(positions: np.ndarray) -> np.ndarray:
    from scipy.signal import butter, sosfiltfilt

    period = round(FILTER_RATE / CUTOFF)
    if len(positions) <= period:
        return positions
    # odd padding of one period of the cutoff keeps the ends where they are
    return np.asarray(sosfiltfilt(butter(2, CUTOFF, fs=FILTER_RATE, output="sos"), positions, axis=0, padlen=period))


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
    error = simulator.noise * math.hypot(ACTUATION_NOISE, ACTUATION_BIAS)
    if error < 0.5 * settings.robot.max_speed:
        return ""
    return (
        f"; simulator.noise: the drive errs by {error:.2g} m/s at robot.max_speed {settings.robot.max_speed:g} m/s,"
        " expected less than half of that"
    )


class RunMonitor:
    """Detects from the poses a run that takes too long or makes no progress; times are of a clock without steps [s]."""

    def __init__(self, limits: Trial, given: float) -> None:
        """`given` is the time at which the goal was given [s]."""
        self.reason = ""  # the reason why the run has ended; "" while it goes on
        self._limits = limits
        self._given = given
        self._begun: float | None = None
        self._anchor: list[float] | None = None
        self._anchored = given
        self._taken = False

    def executing(self, stamp: float) -> None:
        """Starts the count of time, at the goal's first plan [s]; later calls change nothing."""
        if self._begun is None:
            self._begun = stamp

    def commanded(self, maneuver: str) -> None:
        """Notes the newest maneuver: a robot driven by hand or waiting is not stuck until a plan drives it again."""
        if maneuver != STOPPED:
            self._taken = maneuver in (HAND, WAITING)

    def outcome(self, stamp: float, position: np.ndarray) -> str | None:
        """TIMEOUT or STUCK by the newest pose, its time [s] and position (2,) [m]; None while the run goes on.

        TIMEOUT: trial.timeout has passed since the first plan. STUCK: the robot has stayed within trial.stuck_distance
        for trial.stuck_time since the first plan, was not driven by hand and did not wait for what moves; or
        trial.timeout has passed without a plan.
        """
        limits, place = self._limits, position.tolist()
        if self._begun is None:
            return (
                self._end(STUCK, f"no plan within {limits.timeout:g} s") if self._is_over(self._given, stamp) else None
            )
        if self._is_over(self._begun, stamp):
            return self._end(TIMEOUT, f"not there within {limits.timeout:g} s")
        if self._anchor is None or self._taken or math.dist(place, self._anchor) >= limits.stuck_distance:
            self._anchor, self._anchored = place, max(stamp, self._begun)
        if stamp - self._anchored >= limits.stuck_time:
            return self._end(STUCK, f"less than {limits.stuck_distance:g} m away within {limits.stuck_time:g} s")
        return None

    def _is_over(self, begun: float, stamp: float) -> bool:
        return stamp - begun >= self._limits.timeout

    def _end(self, outcome: str, reason: str) -> str:
        self.reason = reason
        return outcome
