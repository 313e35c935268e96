"""An impact of the simulated robot."""

from dataclasses import dataclass

import numpy as np

IMPACT_SPEED = 0.08
"""A contact begun faster than this into the wall is recorded as an impact [m/s]."""


@dataclass(frozen=True, eq=False)
class Impact:
    """One impact, world frame.

    Attributes:
        time: simulated time of the impact [s].
        point: (2,) contact point on the obstacle [m].
        normal: (2,) unit normal out of the obstacle.
        velocity_before, velocity_after: (2,) velocity of the robot's centre [m/s].
    """

    time: float
    point: np.ndarray
    normal: np.ndarray
    velocity_before: np.ndarray
    velocity_after: np.ndarray
