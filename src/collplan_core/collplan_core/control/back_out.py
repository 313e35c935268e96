"""The plan that leads a stuck robot back along where it came from."""

import numpy as np

from collplan_core.plan import Candidates, Contacts, Plan
from collplan_core.state import State

SPEED = 0.3
"""Speed at which a stuck robot backs out [m/s]."""
DISTANCE = 0.3
"""Distance over which a stuck robot backs out [m]."""
SPACING = 0.02
"""Spacing of the samples on the way [m]."""


def back_out(state: State, trail: np.ndarray, pushed: np.ndarray, max_speed: float) -> Plan:
    """A plan from a state back along a trail, DISTANCE at most; straight back where the trail is too short.

    Args:
        trail: (n, 2) where the robot came along, the oldest place first [m].
        pushed: (2,) velocity that was commanded while it was stuck [m/s].
        max_speed: largest speed commanded [m/s].
    """
    way = _spaced(np.vstack([state.position, *trail[::-1]]))
    if len(way) < 3:
        straight = -pushed / max(float(np.hypot(*pushed)), 1e-9)
        way = state.position + np.arange(0.0, DISTANCE + 1e-9, SPACING)[:, None] * straight
    times = state.stamp + SPACING / min(SPEED, max_speed) * np.arange(len(way))
    return Plan(
        stamp=state.stamp,
        times=times,
        positions=way,
        velocities=np.gradient(way, times, axis=0),
        contacts=Contacts.none(),
        aim=way[-1],
        aim_velocity=np.zeros(2),
        terms={},
        candidates=Candidates(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0)),
        n_before_pruning=0,
    )


def _spaced(way: np.ndarray) -> np.ndarray:
    """The first DISTANCE of a way (n, 2) at every SPACING of its length [m]."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(way, axis=0).T))])
    wanted = np.arange(0.0, min(float(along[-1]), DISTANCE) + 1e-9, SPACING)
    return np.column_stack([np.interp(wanted, along, way[:, axis]) for axis in range(2)])
