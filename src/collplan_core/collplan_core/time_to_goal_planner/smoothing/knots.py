"""A plan as knots: states, and the constant accelerations between them, in phases between contacts."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL

APPROACH = 4
"""Knots before and after a contact at which no margin is kept."""
PLACE_GAIN, VELOCITY_GAIN = 20.0, 8.0
"""Gains with which the first pass tracks the plan [1/s^2, 1/s]."""
X, VX, TAU, ONE, AX = 0, 2, 4, 5, 6
"""Places of variables in gains and models: x, y, vx, vy, the duration, 1, ax, ay."""


class Knots(NamedTuple):
    """A trajectory of n constant accelerations in m phases."""

    states: np.ndarray  # (n + 1, 4) x, y, vx, vy, at a contact those after it
    accelerations: np.ndarray  # (n, 2) [m/s^2]
    durations: np.ndarray  # (m,) time between two knots of a phase [s]
    ends: np.ndarray  # (m,) knot at which a phase ends: by a contact, and the last one at the goal
    margins: np.ndarray  # (n,) clearance kept at each knot [m]


class Gains(NamedTuple):
    """Linear functions that give each change of a pass from the changes before it."""

    accelerations: np.ndarray  # (n, 2, 7); of ay by that of ax, too
    durations: np.ndarray  # (m, 7); by the state at the beginning of the phase


@njit
def tracking_gains(knots: Knots) -> Gains:
    """The gains with which the first pass tracks knots that do not join exactly."""
    gains = Gains(np.zeros((len(knots.accelerations), 2, 7)), np.zeros((len(knots.ends), 7)))
    for axis in range(2):
        gains.accelerations[:, axis, X + axis] = -PLACE_GAIN
        gains.accelerations[:, axis, VX + axis] = -VELOCITY_GAIN
    return gains


@njit
def knots_of(rows: np.ndarray, contacts: np.ndarray, begin: float, margin: float) -> Knots:
    """The knots nearest to rows and contacts of a trajectory, as of `sample_trajectory`, from a time [s] on."""
    m, n, first, time = len(contacts) + 1, 0, 0, begin
    ends, durations, after = np.zeros(m, np.int64), np.zeros(m), np.zeros(4)
    for p in range(m):
        until = contacts[p, 0] if p < m - 1 else rows[-1, 0]
        count = max(int(math.ceil((until - time) / CONTROL_INTERVAL - 1e-6)), 2)
        durations[p], time, n = (until - time) / count, until, n + count
        ends[p] = n
    margins = np.full(n, margin)
    for end in ends[:-1]:
        margins[max(end - APPROACH, 0) : end + APPROACH] = 0.0
    knots, time = Knots(np.zeros((n + 1, 4)), np.zeros((n, 2)), durations, ends, margins), begin
    _state_at(rows, begin, knots.states[0])
    for p in range(m):
        for k in range(first, ends[p]):
            time += durations[p]
            row = _state_at(rows, time, after)
            if k + 1 == ends[p] < n:  # of the step that ends in the contact its beginning
                after[2], after[3] = rows[row - 1, 3], rows[row - 1, 4]
            for axis in range(2):
                knots.accelerations[k, axis] = (after[2 + axis] - knots.states[k, 2 + axis]) / durations[p]
            knots.states[k + 1] = after
        first = ends[p]
        if p < m - 1:
            time = contacts[p, 0]
            knots.states[first, 2], knots.states[first, 3] = contacts[p, 3], contacts[p, 4]
    return knots


@njit
def _state_at(rows: np.ndarray, time: float, state: np.ndarray) -> int:
    """Writes the state at a time [s], linear between two rows; the number of the second one."""
    row = min(max(int(np.searchsorted(rows[:, 0], time - 1e-9)), 1), len(rows) - 1)
    share = (time - rows[row - 1, 0]) / (rows[row, 0] - rows[row - 1, 0])
    for c in range(4):
        state[c] = rows[row - 1, 1 + c] + share * (rows[row, 1 + c] - rows[row - 1, 1 + c])
    return row
