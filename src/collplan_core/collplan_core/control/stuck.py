"""Commanded and not moving: pressed against something, wheels that do not turn, or a robot that does not listen."""

import numpy as np

STUCK_TIME = 0.8
"""So long without a way [s]."""
STUCK_DISTANCE = 0.03
"""Way from the middle of the places that counts as none [m]; noise of 2 mm stays far below."""
STUCK_SPEED = 0.15
"""Mean speed commanded from which a way is expected [m/s]."""


def is_stuck(commands: np.ndarray, places: np.ndarray, now: float) -> bool:
    """Whether the robot has not moved for STUCK_TIME although it was commanded to.

    Args:
        commands: (n, 3) time [s] and velocity [m/s], rising times; each holds until the next.
        places: (m, 3) time [s] and measured position [m], rising times on the same clock.
        now: time on that clock [s].
    """
    begin = now - STUCK_TIME
    recent = commands[commands[:, 0] >= begin]
    seen = places[places[:, 0] >= begin]
    # both must reach back to the begin: what was not watched is not judged
    if len(seen) < 3 or places[0, 0] > begin or len(recent) < 3 or commands[0, 0] > begin:
        return False
    middle = seen[:, 1:].mean(axis=0)
    way = np.hypot(*(seen[:, 1:] - middle).T).max()
    return bool(way < STUCK_DISTANCE and np.hypot(*recent[:, 1:].T).mean() > STUCK_SPEED)
