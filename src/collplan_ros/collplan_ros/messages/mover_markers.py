"""Movers as markers: those of a simulated world, which lidar_node reads, and those that the planner has found."""

from collections.abc import Iterable

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from collplan_core.movers.record import Movers
from collplan_ros.messages.conversions import header
from collplan_ros.messages.reading import AHEAD

TRUE = ColorRGBA(r=0.9, g=0.5, b=0.1, a=0.8)
FOUND = ColorRGBA(r=0.8, g=0.2, b=0.6, a=0.5)
HEIGHT = 0.3
"""Drawn height of a mover [m]."""
SHAFT, HEAD = 0.03, 0.07
"""Drawn widths of an arrow [m]."""


def movers_to_markers(
    stamp: float, movers: np.ndarray, frame: str, color: ColorRGBA = TRUE, numbers: Iterable[int] | None = None
) -> MarkerArray:
    """Message of all movers (k, 5) x, y [m], vx, vy [m/s], radius [m] at a stamp [s], which replace those before.

    A cylinder each, and an arrow where it moves; their ids are the `numbers` (k,), 0, 1, ... by default.
    """
    head = header(stamp, frame)
    markers = [Marker(header=head, action=Marker.DELETEALL)]
    for number, row in zip(range(len(movers)) if numbers is None else numbers, movers.tolist(), strict=True):
        x, y, vx, vy, radius = row
        pose = Pose(position=Point(x=x, y=y, z=HEIGHT / 2), orientation=Quaternion(w=1.0))
        size = Vector3(x=2.0 * radius, y=2.0 * radius, z=HEIGHT)
        kind, about = Marker.CYLINDER, {"header": head, "id": int(number), "color": color}
        markers.append(Marker(ns="movers", type=kind, pose=pose, scale=size, **about))
        if vx or vy:
            ends = [Point(x=x + t * vx, y=y + t * vy, z=HEIGHT) for t in (0.0, AHEAD)]
            width = Vector3(x=SHAFT, y=HEAD)
            markers.append(Marker(ns="velocities", type=Marker.ARROW, points=ends, scale=width, **about))
    return MarkerArray(markers=markers)


def found_to_markers(found: Movers, stamp: float, frame: str) -> MarkerArray:
    """Message of the movers that a robot has found, at a stamp [s], each as the disc that holds all its parts."""
    numbers, rows = found.whole
    return movers_to_markers(stamp, rows, frame, FOUND, numbers.tolist())
