"""Whether the robot is commanded and does not move: one rule over recent poses and commands, without memory."""

import numpy as np

WINDOW = 0.7
"""Time looked back [s]."""
COMMANDED = 0.15
"""A command slower than this asks for no motion that could be told from noise [m/s]."""
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


def why_stuck(poses: np.ndarray, commands: np.ndarray, max_acceleration: float) -> str:
    """Why the robot counts as stuck, in words; "" where it does not.

    Stuck is a robot that was commanded at least COMMANDED all through the last WINDOW but for PAUSE, and went almost no
    way, not even to and fro, as after a rebound. Where it should have got to is where its commands lead, or less far
    where from rest it could not: commanded to and fro, it should not have. As long as poses or commands do not reach
    back so far, nothing is said. How often they come makes no difference.

    Args:
        poses: (n, 3) time [s], x, y [m], times rising; the newest one is now.
        commands: (m, 3) time [s] from which a command is in force until the next, and its velocity [m/s], times rising.
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
    velocities, lasted = commands[first:, 1:], np.diff(np.minimum(since, now), append=now)
    speeds = np.hypot(*velocities.T)
    if lasted[speeds < COMMANDED].sum() > PAUSE:
        return ""
    lead = float(np.hypot(*(lasted @ velocities)))
    way = _way(poses[poses[:, 0] >= begin])
    if lead < NOWHERE or way > SHARE * min(lead, 0.5 * max_acceleration * WINDOW**2):
        return ""
    mean = float(speeds @ lasted) / WINDOW
    return f"commanded {mean:.2f} m/s for {WINDOW:g} s and moved {way:.2f} m"


def _way(poses: np.ndarray) -> float:
    """Length of the way over the mean places in PARTS of WINDOW [m], by poses (n, 3) time [s], x, y [m] within it."""
    part = ((poses[:, 0] - poses[-1, 0] + WINDOW) * (PARTS / WINDOW)).astype(int).clip(0, PARTS - 1)
    count = np.bincount(part)
    seen = count > 0
    x, y = (np.bincount(part, poses[:, axis])[seen] / count[seen] for axis in (1, 2))
    return float(np.hypot(np.diff(x), np.diff(y)).sum())
