"""The mounting pose of a sensor from the frames that lie between it and the robot."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

LEVEL = math.radians(15.0)
"""Largest angle between the axis of a LIDAR and the vertical [rad]."""


@dataclass(frozen=True)
class LidarMount:
    """Mounting pose of a LIDAR: x forward and y left of the robot's centre [m], heading [rad], and whether inverted."""

    x: float
    y: float
    yaw: float
    mirrored: bool


@dataclass(frozen=True, eq=False)
class Link:
    """A frame in its parent: position (3,) [m], and the unit quaternion (4,) x, y, z, w that turns it."""

    parent: str
    position: ArrayLike
    quaternion: ArrayLike


def place_in(links: Mapping[str, Link], base: str, frame: str) -> tuple[np.ndarray, Rotation] | None:
    """Position (3,) [m] and rotation of a frame in another, by the frame above both that is nearest; None without."""
    above, below = _ancestors(links, frame), _ancestors(links, base)
    common = next((each for each in above if each in below), None)
    if common is None:
        return None
    (at, turn), (base_at, base_turn) = above[common], below[common]
    return base_turn.inv().apply(at - base_at), base_turn.inv() * turn


def _ancestors(links: Mapping[str, Link], frame: str) -> dict[str, tuple[np.ndarray, Rotation]]:
    """Position and rotation of a frame in itself and in each frame above it, the nearest first."""
    position, rotation, found = np.zeros(3), Rotation.identity(), {}
    while frame not in found:
        found[frame] = position, rotation
        if frame in links:
            link, turn = links[frame], Rotation.from_quat(links[frame].quaternion)
            position, rotation, frame = link.position + turn.apply(position), turn * rotation, link.parent
    return found


def mount_in(links: Mapping[str, Link], base: str, frame: str) -> LidarMount | None:
    """The mounting pose of a LIDAR's frame on the robot's frame; None where no links join them.

    Raises:
        ValueError: the LIDAR is not level, so that its scans are no plan of the room.
    """
    place = place_in(links, base, frame)
    if place is None:
        return None
    position, rotation = place
    ahead, up = rotation.apply([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    if abs(up[2]) < math.cos(LEVEL):
        tilt = math.degrees(math.acos(abs(up[2])))
        raise ValueError(f"{frame} is tilted by {tilt:.0f} degrees on {base}, expected a level LIDAR")
    return LidarMount(float(position[0]), float(position[1]), math.atan2(ahead[1], ahead[0]), bool(up[2] < 0.0))
