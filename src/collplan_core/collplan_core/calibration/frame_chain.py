"""The mounting pose of a sensor from the frames that lie between it and the robot."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from collplan_core.calibration.lidar_fit import LidarMount

LEVEL = math.radians(15.0)
"""Largest angle between the axis of a LIDAR and the vertical [rad]."""


@dataclass(frozen=True, eq=False)
class Link:
    """A frame in its parent: position (3,) [m], and the unit quaternion (4,) x, y, z, w that turns it."""

    parent: str
    position: ArrayLike
    quaternion: ArrayLike


def mount_in(links: Mapping[str, Link], base: str, frame: str) -> LidarMount | None:
    """The mounting pose of a LIDAR's frame on the robot's frame; None where no chain of links joins them.

    Raises:
        ValueError: the LIDAR is not level, so that its scans are no plan of the room.
    """
    position, rotation, at = np.zeros(3), Rotation.identity(), frame
    for _ in links:
        if at == base or at not in links:
            break
        link, turn = links[at], Rotation.from_quat(links[at].quaternion)
        position, rotation, at = link.position + turn.apply(position), turn * rotation, link.parent
    if at != base:
        return None
    ahead, up = rotation.apply([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    if abs(up[2]) < math.cos(LEVEL):
        tilt = math.degrees(math.acos(abs(up[2])))
        raise ValueError(f"{frame} is tilted by {tilt:.0f} degrees on {base}, expected a level LIDAR")
    return LidarMount(float(position[0]), float(position[1]), math.atan2(ahead[1], ahead[0]), bool(up[2] < 0.0))
