"""The movers of a simulated world as markers, which RViz shows and lidar_node reads."""

import numpy as np
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from collplan_ros.messages.conversions import header
from collplan_ros.messages.reading import MessageError, check_finite, check_frame, seconds_from_stamp

COLOR = ColorRGBA(r=0.9, g=0.5, b=0.1, a=0.8)
HEIGHT = 0.3
"""Drawn height of a mover [m]."""


def movers_to_markers(stamp: float, discs: np.ndarray, frame: str) -> MarkerArray:
    """Message of discs (k, 3) x, y, radius [m] at a stamp [s]: a cylinder each."""
    return MarkerArray(
        markers=[
            Marker(
                header=header(stamp, frame),
                ns="movers",
                id=number,
                type=Marker.CYLINDER,
                pose=Pose(position=Point(x=x, y=y, z=HEIGHT / 2), orientation=Quaternion(w=1.0)),
                scale=Vector3(x=2.0 * radius, y=2.0 * radius, z=HEIGHT),
                color=COLOR,
            )
            for number, (x, y, radius) in enumerate(discs.tolist())
        ]
    )


def movers_from_markers(message: MarkerArray, frame: str) -> tuple[float, np.ndarray]:
    """Stamp [s] and discs (k, 3) x, y, radius [m] of such a message.

    Raises:
        MessageError: no marker, another frame, or a number that is not finite.
    """
    if not message.markers:
        raise MessageError("markers: got none, expected one for each mover")
    rows = []
    for marker in message.markers:
        check_frame("markers.header.frame_id", marker.header.frame_id, frame)
        rows.append((marker.pose.position.x, marker.pose.position.y, marker.scale.x / 2))
        check_finite("markers", *rows[-1])
    return seconds_from_stamp(message.markers[0].header.stamp), np.array(rows)
