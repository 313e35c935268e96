"""The mounting pose of a sensor from the frames that lie between it and the robot."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from collplan_core.calibration.lidar_fit import LidarMount

LEVEL = math.radians(15.0)
"""Largest angle between the axis of a LIDAR and the vertical [rad]."""


@dataclass(frozen=True, eq=False)
class Link:
    """A frame in its parent: position (3,) [m] and rotation."""

    parent: str
    position: np.ndarray
    rotation: Rotation


def mount_in(links: Mapping[str, Link], base: str, frame: str) -> LidarMount | None:
    """The mounting pose of a LIDAR's frame on the robot's frame; None where no chain of links joins them.

    Raises:
        ValueError: the LIDAR is not level, so that its scans are no plan of the room.
    """
    position, rotation, at = np.zeros(3), Rotation.identity(), frame
    for _ in links:
        if at == base or at not in links:
            break
        link = links[at]
        position, rotation, at = link.position + link.rotation.apply(position), link.rotation * rotation, link.parent
    if at != base:
        return None
    ahead, up = rotation.apply([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    if abs(up[2]) < math.cos(LEVEL):
        tilt = math.degrees(math.acos(abs(up[2])))
        raise ValueError(f"{frame} is tilted by {tilt:.0f} degrees on {base}, expected a level LIDAR")
    return LidarMount(float(position[0]), float(position[1]), math.atan2(ahead[1], ahead[0]), bool(up[2] < 0.0))
