"""Every random number of a run, each kind from a stream of its own, and the faults of a motion capture on request."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from math import ceil, pi, radians, remainder, tau

import numpy as np

from collplan_core.evaluation.run_end import ACTUATION_BIAS, ACTUATION_NOISE
from collplan_core.parameters import Simulation
from collplan_core.poses.pose_filter import PoseSample
from omnipuck_sim.robot.vector import Vector

LATE, BURSTS, REPEATS = "late", "bursts", "repeats"
MORE_LATENCY = 0.2
"""Additional delay of poses with fault `late` [s]."""
HOUR = 3600.0
"""Error of the stamps of poses with faults `hour_ahead` and `hour_back` [s]."""

BURST, APART = 0.05, 0.01
"""Time from burst to burst of poses [s], and the share of the time between two of one burst that is left of it."""
RENEWED = 0.1
"""Time for which a value is repeated [s]."""
TOLERANCE = 1e-6
"""Sums of decimal times must not decide [s]."""


def _turned(angle: float) -> Callable[[PoseSample], PoseSample]:
    return lambda sample: replace(sample, yaw=remainder(sample.yaw + angle, tau))


_FAULTS: dict[str, Callable[[PoseSample], PoseSample]] = {
    "yaw_90": _turned(pi / 2),
    "yaw_180": _turned(pi),
    "tilt": lambda sample: replace(sample, tilt=radians(30.0)),
    "lift": lambda sample: replace(sample, height=sample.height + 0.2),
    "hour_ahead": lambda sample: replace(sample, stamp=sample.stamp + HOUR),
    "hour_back": lambda sample: replace(sample, stamp=sample.stamp - HOUR),
}


def faulty(sample: PoseSample, fault: str, before: PoseSample | None = None) -> PoseSample:
    """The measured pose with this fault, a value of simulator.mocap_fault, after the one that was given `before`."""
    if fault == BURSTS:
        return replace(sample, stamp=sample.stamp + (1.0 - APART) * added_latency(fault, sample.stamp))
    if fault == REPEATS and before is not None:
        is_new = (sample.stamp + TOLERANCE) // RENEWED > (before.stamp + TOLERANCE) // RENEWED
        return sample if is_new else replace(before, stamp=sample.stamp)
    return _FAULTS[fault](sample) if fault in _FAULTS else sample


def added_latency(fault: str, measured: float) -> float:
    """Returns how much later a pose comes with this fault [s] that was measured at a time [s]."""
    if fault == BURSTS:
        return ceil((measured - TOLERANCE) / BURST) * BURST - measured
    return MORE_LATENCY if fault == LATE else 0.0


ACTUATION_RATE = 20.0
"""Draws of the actuation noise per simulated second [Hz]."""

START_NOISE = 0.01
"""Spread of the start, standard deviation by axis, at level 1 [m]."""


class Noise:
    """Noise of one run, drawn from its seed; equal in every process."""

    def __init__(self, settings: Simulation, seed: int) -> None:
        streams = [np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(6)]
        *normal, self.rebound, yaw = streams
        self._actuation, bias, self._mocap, self._start = map(_pairs, normal)
        self._yaw = _pairs(yaw, 1)
        self._settings = settings
        self._bias = _pair(bias, settings.noise * ACTUATION_BIAS)

    def actuation(self) -> Vector:
        """Error of the velocity that the wheels aim at, bias included, for one actuation period [m/s]."""
        x, y = _pair(self._actuation, self._settings.noise * ACTUATION_NOISE)
        return x + self._bias[0], y + self._bias[1]

    def mocap(self) -> Vector:
        """Error of one measured position [m]."""
        return _pair(self._mocap, self._settings.noise * self._settings.mocap_noise)

    def mocap_yaw(self) -> float:
        """Error of one measured yaw [rad]."""
        return float(self._settings.noise * self._settings.mocap_yaw_noise * next(self._yaw)[0])

    def start(self) -> Vector:
        """Error of the start [m]."""
        return _pair(self._start, self._settings.noise * START_NOISE)


def _pairs(random: np.random.Generator, n: int = 2) -> Iterator[list[float]]:
    """Lists of n numbers drawn from the standard normal distribution, many in one call of numpy."""
    while True:
        yield from random.standard_normal((64, n)).tolist()


def _pair(draws: Iterator[list[float]], deviation: float) -> Vector:
    x, y = next(draws)
    return deviation * x, deviation * y
