"""Initial state of a new plan: the measured state, corrected by the prediction of the plan in force.

The measured velocity is that of half a filter window ago, and for some poses after an impact it is that of before, or
that of a few noisy poses. The plan in force says what should have happened meanwhile.
"""

from dataclasses import dataclass

import numpy as np

from collplan_core.parameters import Mocap
from collplan_core.state import State

TRUST = 0.5
"""Share of the measured velocity's deviation that counts, without a contact."""
SURPRISE = 0.35
"""Deviation of the measured velocity beyond which the plan did not happen, and the measurement alone counts [m/s]."""
UNDETECTED = 0.06
"""A foreseen contact may be so long past without a trace in the measured velocity [s]."""


@dataclass(frozen=True, eq=False)
class Expected:
    """Prediction of the plan in force."""

    times: np.ndarray  # (n,) times of its samples [s]
    positions: np.ndarray  # positions, velocities: (n, 2) at these times [m], [m/s]
    velocities: np.ndarray
    contact_times: np.ndarray  # (k,) times of its contacts [s]

    def positions_at(self, times: np.ndarray) -> np.ndarray:
        """(m, 2) positions at times (m,) [s]; the last one after the end [m]."""
        return np.column_stack([np.interp(times, self.times, self.positions[:, a]) for a in range(2)])

    def velocity_at(self, time: float) -> np.ndarray:
        """(2,) velocity at a time [s]; the one after a contact at the moment of it [m/s]."""
        i = int(np.searchsorted(self.times, time, side="right")) - 1
        i = min(max(i, 0), len(self.times) - 2)
        share = (time - self.times[i]) / (self.times[i + 1] - self.times[i])
        a, b = self.velocities[i], self.velocities[i + 1]
        # between a sample and a contact the velocity does not run from one to the other
        if np.hypot(*(b - a)) > 0.2:
            return a if share < 0.999 else b
        return a + min(max(share, 0.0), 1.0) * (b - a)


def initial_velocity(state: State, expected: Expected | None, mocap: Mocap) -> np.ndarray:
    """(2,) the velocity at a state's stamp: measured, foreseen, or between them [m/s]."""
    if expected is None or not expected.times[0] <= state.stamp <= expected.times[-1]:
        return state.velocity
    lag = 0.5 * mocap.velocity_window
    foreseen = expected.velocity_at(state.stamp)
    before = expected.velocity_at(max(state.stamp - lag, expected.times[0]))
    contacts = expected.contact_times
    recent = contacts[(contacts <= state.stamp) & (contacts > state.stamp - 2.0 * lag - UNDETECTED)]
    if len(recent):
        return _after_contact(state, expected, foreseen, float(recent[-1]), lag)
    deviation = state.velocity - before
    if np.hypot(*deviation) > SURPRISE:
        return state.velocity
    return foreseen + TRUST * deviation


def _after_contact(
    state: State, expected: Expected, foreseen: np.ndarray, contact_time: float, lag: float
) -> np.ndarray:
    """The rebound as foreseen shortly before, until the measured velocity shows it."""
    before = expected.velocity_at(max(contact_time - 1e-3, expected.times[0]))
    seen = np.hypot(*(state.velocity - foreseen)) < np.hypot(*(state.velocity - before))
    age = state.stamp - contact_time
    if not seen:
        return foreseen if age < UNDETECTED else state.velocity
    weight = TRUST * min(age / (2.0 * lag), 1.0)
    return foreseen + weight * (state.velocity - foreseen)
