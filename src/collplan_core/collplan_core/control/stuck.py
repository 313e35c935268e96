"""Detection of a robot that is commanded and does not move: one rule over recent poses and commands."""

import math

import numpy as np

from collplan_core.jit import njit

WINDOW = 0.7
"""Time looked back [s]."""
COMMANDED = 0.15
"""A command slower than this causes no motion that differs from noise [m/s]."""
PAUSE = 0.12
"""Commands may be slower for so long in WINDOW [s]: a plan that begins anew at each bump begins slowly."""
NOWHERE = 0.05
"""Commands that lead less far in WINDOW lead nowhere [m]."""
SHARE = 0.15
"""A robot whose way is less than this share of the distance that it should have gone has not moved.

One of twice the believed mass that is commanded back goes 0.057 m of 0.37 m in WINDOW while it turns round.
"""
PARTS = 5
"""The way is that over the mean places in so many parts of WINDOW: noise of 2 mm in each pose is not a way."""

_NOT_STUCK = math.nan, math.nan


def why_stuck(poses: np.ndarray, commands: np.ndarray, max_acceleration: float) -> str:
    """Returns the reason why the robot counts as stuck; "" where it does not.

    A robot is stuck that was commanded at least COMMANDED throughout the last WINDOW, PAUSE excepted, and hardly moved,
    not even to and fro, as after a rebound. The expected distance is that to which its commands lead, less where it
    cannot be reached from rest; commands to and fro lead nowhere. While poses or commands do not cover WINDOW, the
    robot does not count as stuck. The rate of either makes no difference.

    Args:
        poses: (n, 3) time [s], x, y [m], times rising; the newest one is now.
        commands: (m, 3) time [s] from which a command is in force until the next, and its velocity [m/s], times rising.
        max_acceleration: largest acceleration of the wheels [m/s^2].
    """
    mean, way = _speed_and_way(np.ascontiguousarray(poses), np.ascontiguousarray(commands), max_acceleration)
    return "" if math.isnan(mean) else f"commanded {mean:.2f} m/s for {WINDOW:g} s and moved {way:.2f} m"


@njit
def _speed_and_way(poses: np.ndarray, commands: np.ndarray, max_acceleration: float) -> tuple[float, float]:
    """Mean speed commanded [m/s] and length of the way [m] in WINDOW of a robot that is stuck; NaN where it is not."""
    if len(poses) == 0 or len(commands) == 0:
        return _NOT_STUCK
    now = poses[-1, 0]
    begin = now - WINDOW
    if poses[0, 0] > begin or commands[0, 0] > begin:
        return _NOT_STUCK
    slow, length, lead_x, lead_y = 0.0, 0.0, 0.0, 0.0
    # the command in force when the window begins, and those since
    first = int(np.searchsorted(commands[:, 0], begin, side="right")) - 1
    for k in range(first, len(commands)):
        until = commands[k + 1, 0] if k + 1 < len(commands) else now
        lasted = min(until, now) - min(max(commands[k, 0], begin), now)
        speed = math.hypot(commands[k, 1], commands[k, 2])
        slow += lasted if speed < COMMANDED else 0.0
        length += lasted * speed
        lead_x, lead_y = lead_x + lasted * commands[k, 1], lead_y + lasted * commands[k, 2]
    lead = math.hypot(lead_x, lead_y)
    if slow > PAUSE or lead < NOWHERE:
        return _NOT_STUCK
    way = _way(poses, begin)
    if way > SHARE * min(lead, 0.5 * max_acceleration * WINDOW**2):
        return _NOT_STUCK
    return length / WINDOW, way


@njit
def _way(poses: np.ndarray, begin: float) -> float:
    """Length of the way since `begin` over the mean places in PARTS of WINDOW [m]; poses (n, 3) time [s], x, y [m]."""
    count, x, y = np.zeros(PARTS), np.zeros(PARTS), np.zeros(PARTS)
    for k in range(int(np.searchsorted(poses[:, 0], begin)), len(poses)):
        part = int((poses[k, 0] - poses[-1, 0] + WINDOW) * (PARTS / WINDOW))
        part = min(max(part, 0), PARTS - 1)
        count[part] += 1.0
        x[part] += poses[k, 1]
        y[part] += poses[k, 2]
    # a part without poses has no place
    seen = np.flatnonzero(count)
    x, y = x[seen] / count[seen], y[seen] / count[seen]
    way = 0.0
    for part in range(1, len(x)):
        way += math.hypot(x[part] - x[part - 1], y[part] - y[part - 1])
    return way
