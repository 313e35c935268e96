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
    """Ways in which motion may follow commands: rows of delay [s], mass, and the command's matrix xx, xy, yx, yy.

    Attributes:
        rows: (n, 6). The first len(DELAYS) * len(MASSES) are plain, by delay, then mass; then dead wheels: braked,
            coasting, and almost without force; then turned or mirrored ones.
        n_plain, n_dead: numbers of plain ways and of dead wheels.
    """

    rows: np.ndarray
    n_plain: int
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
_OF_EVERY_HEADING = np.array([*_PLAIN, *_DEAD, *_TURNED])


def ways(yaw: float) -> Ways:
    """All ways for a robot with this heading [rad], whose own x or y may be mirrored."""
    c, s = math.cos(2.0 * yaw), math.sin(2.0 * yaw)
    mirrored = [
        (delay, 1.0, sign * c, sign * s, sign * s, -sign * c) for delay in _QUICK_DELAYS for sign in (1.0, -1.0)
    ]
    return Ways(np.concatenate([_OF_EVERY_HEADING, mirrored]), len(_PLAIN), len(_DEAD))


@njit
def misfits(
    commands: np.ndarray, velocities: np.ndarray, begin: float, rows: np.ndarray, max_acceleration: float, lag: float
) -> np.ndarray:
    """Integrals of the squared error of the velocity under each way [m^2/s].

    Returns:
        (n, 2) from the velocity measured at the begin on; and what is left of it where that one is as uncertain as the
        others, so that an error common to them all may be its own.

    Args:
        commands: (k, 3) time [s] and velocity [m/s, world frame], rising times; none before the first.
        velocities: (m, 2) measured [m/s], STEP apart from `begin` [s] on.
        rows: (n, 6) `Ways.rows`.
        max_acceleration, lag: those of robot.mass [m/s^2], [s].
    """
    result, n = np.zeros((len(rows), 2)), len(velocities)
    for j in range(len(rows)):
        delay, mass = rows[j, 0], rows[j, 1]
        law = VelocityLaw(max_acceleration / mass, lag * mass, STEP, math.exp(-STEP / (lag * mass)))
        vx, vy = velocities[0, 0], velocities[0, 1]
        newest, total, common_x, common_y = 0, 0.0, 0.0, 0.0
        for k in range(1, n):
            # half a step of tolerance would be a delay; this is for sums of decimal times
            time = begin + (k - 1) * STEP - delay + 1e-6
            while newest + 1 < len(commands) and commands[newest + 1, 0] <= time:
                newest += 1
            ux, uy = 0.0, 0.0
            if commands[newest, 0] <= time:
                ux = rows[j, 2] * commands[newest, 1] + rows[j, 3] * commands[newest, 2]
                uy = rows[j, 4] * commands[newest, 1] + rows[j, 5] * commands[newest, 2]
            vx, vy = velocity_after_step(law, vx, vy, ux, uy)
            error_x, error_y = vx - velocities[k, 0], vy - velocities[k, 1]
            total += error_x * error_x + error_y * error_y
            common_x, common_y = common_x + error_x, common_y + error_y
        result[j, 0] = total * STEP
        result[j, 1] = (total - (common_x * common_x + common_y * common_y) / n) * STEP
    return result
