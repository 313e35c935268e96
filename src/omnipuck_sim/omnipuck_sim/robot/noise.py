"""Every random number of a run, each kind from a stream of its own: strategies meet the same noise."""

from collections.abc import Iterator

import numpy as np

from collplan_core.parameters import Simulation
from omnipuck_sim.robot.vector import Vector

ACTUATION_RATE = 20.0
"""Draws of the actuation noise per simulated second [Hz]."""


class Noise:
    """Noise of one run, drawn from its seed; equal in every process."""

    def __init__(self, settings: Simulation, seed: int) -> None:
        streams = [np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(6)]
        *normal, self.rebound, yaw = streams
        self._actuation, bias, self._mocap, self._start = map(_pairs, normal)
        self._yaw = _pairs(yaw, 1)
        self._settings = settings
        self._bias = _pair(bias, settings.noise * settings.actuation_bias)

    def actuation(self) -> Vector:
        """Error of the velocity that the wheels aim at, bias included, for one actuation period [m/s]."""
        x, y = _pair(self._actuation, self._settings.noise * self._settings.actuation_noise)
        return x + self._bias[0], y + self._bias[1]

    def mocap(self) -> Vector:
        """Error of one measured position [m]."""
        return _pair(self._mocap, self._settings.noise * self._settings.mocap_noise)

    def mocap_yaw(self) -> float:
        """Error of one measured yaw [rad]."""
        return float(self._settings.noise * self._settings.mocap_yaw_noise * next(self._yaw)[0])

    def start(self) -> Vector:
        """Error of the start [m]."""
        return _pair(self._start, self._settings.noise * self._settings.start_noise)


def _pairs(random: np.random.Generator, n: int = 2) -> Iterator[list[float]]:
    """Lists of n numbers drawn from the standard normal distribution, many in one call of numpy."""
    while True:
        yield from random.standard_normal((64, n)).tolist()


def _pair(draws: Iterator[list[float]], deviation: float) -> Vector:
    x, y = next(draws)
    return deviation * x, deviation * y
