"""The velocity command that the controller sends to the robot."""

from dataclasses import dataclass

import numpy as np

FREE_SPACE = "free_space"
BOUNDARY_FOLLOWING = "boundary_following"
FLOW_THROUGH = "flow_through"
STOPPED = "stopped"
MANEUVERS = (FREE_SPACE, BOUNDARY_FOLLOWING, FLOW_THROUGH, STOPPED)
HAND = "hand"
"""In the place of a maneuver: a person drives, and there is no reference."""
WAITING = "waiting"
"""In the place of a maneuver: the robot stands, or hardly moves, because of what moves near it."""
STANDING = (STOPPED, WAITING)
WITHOUT_REFERENCE = (HAND, *STANDING)


@dataclass(frozen=True, eq=False)
class Command:
    """A body-frame velocity command and what led to it."""

    velocity: np.ndarray  # (2,) [m/s, body frame]
    yaw_rate: float  # [rad/s]
    maneuver: str  # one of MANEUVERS, HAND or WAITING
    reference: np.ndarray  # (2,) position tracked now [m, world frame]; NaN when stopped, waiting or driven by hand
    reason: str = ""  # reason why the robot is stopped, or slower than it was to be; empty otherwise


def stopped(reason: str) -> Command:
    """The zero command, with the reason for it."""
    return Command(np.zeros(2), 0.0, STOPPED, np.full(2, np.nan), reason)
