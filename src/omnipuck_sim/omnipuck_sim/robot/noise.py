"""Every random number of a run, each kind from a stream of its own: strategies meet the same noise."""

import numpy as np

from collplan_core.parameters import Simulation
from omnipuck_sim.robot.vector import Vector

ACTUATION_RATE = 20.0
"""Draws of the actuation noise per simulated second [Hz]."""


class Noise:
    """Noise of one run, drawn from its seed; equal in every process."""

    def __init__(self, settings: Simulation, seed: int) -> None:
        streams = [np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(6)]
        self._actuation, bias, self._mocap, self._start, self.rebound, self._yaw = streams
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
        return float(self._settings.noise * self._settings.mocap_yaw_noise * self._yaw.standard_normal())

    def start(self) -> Vector:
        """Error of the start [m]."""
        return _pair(self._start, self._settings.noise * self._settings.start_noise)


def _pair(random: np.random.Generator, deviation: float) -> Vector:
    x, y = (deviation * random.standard_normal(2)).tolist()
    return x, y
