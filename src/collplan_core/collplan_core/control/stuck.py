"""Whether the robot is commanded and does not move: one rule over recent poses and commands, without memory."""

import math

import numpy as np

WINDOW = 0.7
"""Time looked back [s]."""
COMMANDED = 0.15
"""A command slower than this asks for no motion that could be told from noise [m/s]."""
SHARE = 0.25
"""A robot that stays within a box with sides of this share of the distance that it should have gone has not moved."""


def why_stuck(poses: np.ndarray, commands: np.ndarray, max_acceleration: float) -> str:
    """Why the robot counts as stuck, in words; "" where it does not.

    Stuck is a robot that was commanded at least COMMANDED all through the last WINDOW, in whatever direction, and
    stayed where it was. What it should have gone is the commanded speed over that time, or less where from rest it
    could not. As long as poses or commands do not reach back so far, nothing is said. How often they come makes no
    difference.

    Args:
        poses: (n, 3) time [s], x, y [m], times rising; the newest one is now.
        commands: (m, 2) time [s] from which a command is in force until the next, and its speed [m/s], times rising.
        max_acceleration: of the wheels [m/s^2].
    """
    if len(poses) == 0 or len(commands) == 0:
        return ""
    now = poses[-1, 0]
    begin = now - WINDOW
    if poses[0, 0] > begin or commands[0, 0] > begin:
        return ""
    # the command in force when the window begins, and those since
    first = int(np.searchsorted(commands[:, 0], begin, side="right")) - 1
    since = np.maximum(commands[first:, 0], begin)
    speeds, lasted = commands[first:, 1], np.diff(np.minimum(since, now), append=now)
    if speeds.min() < COMMANDED:
        return ""
    expected = min(float(speeds @ lasted), 0.5 * max_acceleration * WINDOW**2)
    sides = np.ptp(poses[poses[:, 0] >= begin, 1:], axis=0)
    if sides.max() > SHARE * expected:
        return ""
    mean = float(speeds @ lasted) / WINDOW
    return f"commanded {mean:.2f} m/s for {WINDOW:g} s and moved {math.hypot(*sides):.2f} m"
