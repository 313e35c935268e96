"""Fit of measured motion to the commands, under each of many ways in which it may follow from them.

A way is a delay, a mass, and a turn or mirroring of the command. Under each, the robot's velocity law is integrated
through a window from the velocity measured at its begin, and compared with the velocities measured.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.velocity_law import VelocityLaw, velocity_after_step

STEP = 0.025
"""Spacing of the velocities compared, and of the delays [s]."""
LONGEST_DELAY = 0.45
"""[s]"""
MASSES = (0.7, 1.0, 1.4, 2.0, 2.8)
"""Masses over robot.mass, with the same motors."""
_QUICK_DELAYS = (0.0, 0.05, 0.1)
_TURNS = (0.5 * math.pi, math.pi, 1.5 * math.pi)
_COASTING = 1e6


class Ways(NamedTuple):
    """Ways in which motion may follow commands: rows of delay [s], mass, and the command's matrix xx, xy, yx, yy."""

    rows: np.ndarray
    """(n, 6). The first len(DELAYS) * len(MASSES) are plain, by delay, then mass; then dead wheels: braked, coasting,
    and almost without force; then turned or mirrored ones."""
    n_plain: int  # n_plain, n_dead: numbers of plain ways and of dead wheels
    n_dead: int


DELAYS = np.arange(round(LONGEST_DELAY / STEP) + 1) * STEP
_SAME = (1.0, 0.0, 0.0, 1.0)
_PLAIN = [(delay, mass, *_SAME) for delay in DELAYS.tolist() for mass in MASSES]
_DEAD = [(0.0, 1.0, 0.0, 0.0, 0.0, 0.0), (0.0, _COASTING, *_SAME), (0.0, 3.5, *_SAME), (0.0, 5.0, *_SAME)]
_TURNED = [
    (delay, mass, math.cos(turn), -math.sin(turn), math.sin(turn), math.cos(turn))
    for delay in _QUICK_DELAYS
    for mass in (1.0, 2.0)
    for turn in _TURNS
]
_MIRRORED = [(delay, 1.0, sign, sign, sign, sign) for delay in _QUICK_DELAYS for sign in (1.0, -1.0)]
_SIGNED = np.array([*_PLAIN, *_DEAD, *_TURNED, *_MIRRORED])
"""Rows of the ways, those of mirrored commands last, and without their matrix."""


def ways(yaw: float) -> Ways:
    """All ways for a robot with this heading [rad], whose own x or y may be mirrored."""
    c, s, rows = math.cos(2.0 * yaw), math.sin(2.0 * yaw), _SIGNED.copy()
    rows[-len(_MIRRORED) :, 2:] *= (c, s, s, -c)
    return Ways(rows, len(_PLAIN), len(_DEAD))


@njit
def misfits(
    commands: np.ndarray, velocities: np.ndarray, begin: float, rows: np.ndarray, max_acceleration: float, lag: float
) -> np.ndarray:
    """Integrals of the squared error of the velocity under each way [m^2/s].

    Returns (n, 2) from the velocity measured at the begin on; and what is left of it where that one is as uncertain as
    the others, so that an error common to them all may be its own.

    Args:
        commands: (k, 3) time [s] and velocity [m/s, world frame], rising times; none before the first.
        velocities: (m, 2) measured [m/s], STEP apart from `begin` [s] on.
        rows: (n, 6) `Ways.rows`.
        max_acceleration, lag: those of robot.mass [m/s^2], [s].
    """
    m, n = len(rows), len(velocities)
    result, common, v, decays = np.zeros((m, 2)), np.zeros((m, 2)), np.empty((m, 2)), np.empty(m)
    newest, accelerations, lags = np.zeros(m, np.int64), max_acceleration / rows[:, 1], lag * rows[:, 1]
    for j in range(m):
        v[j], decays[j] = velocities[0], math.exp(-STEP / lags[j])
    for k in range(1, n):
        # the ways in the inner loop, as a processor computes several at once that do not wait for each other
        for j in range(m):
            # half a step of tolerance would be a delay; this is for sums of decimal times
            time = begin + (k - 1) * STEP - rows[j, 0] + 1e-6
            i = newest[j]
            while i + 1 < len(commands) and commands[i + 1, 0] <= time:
                i += 1
            newest[j] = i
            ux, uy = 0.0, 0.0
            if commands[i, 0] <= time:
                ux = rows[j, 2] * commands[i, 1] + rows[j, 3] * commands[i, 2]
                uy = rows[j, 4] * commands[i, 1] + rows[j, 5] * commands[i, 2]
            law = VelocityLaw(accelerations[j], lags[j], STEP, decays[j])
            vx, vy = velocity_after_step(law, v[j, 0], v[j, 1], ux, uy)
            error_x, error_y = vx - velocities[k, 0], vy - velocities[k, 1]
            v[j, 0], v[j, 1] = vx, vy
            result[j, 0] += error_x * error_x + error_y * error_y
            common[j, 0] += error_x
            common[j, 1] += error_y
    for j in range(m):
        total, (x, y) = result[j, 0], common[j]
        result[j, 0], result[j, 1] = total * STEP, (total - (x * x + y * y) / n) * STEP
    return result
