"""Movers read out of their markers, by attributes alone: of a live graph, and of a recording read without ROS."""

from typing import Any

import numpy as np

from collplan_ros.messages.reading import MessageError, check_finite, check_frame, seconds_from_stamp

ARROW, CYLINDER = 0, 3
"""Types of a visualization_msgs/Marker: a mover is a cylinder, and an arrow of the same id where it moves."""
AHEAD = 0.5
"""An arrow leads to where the mover would be after so long [s]."""


def movers_from_markers(message: Any, frame: str) -> tuple[float, np.ndarray]:
    """Stamp [s] and movers (k, 5) x, y [m], vx, vy [m/s], radius [m] of a MarkerArray.

    MessageError: no marker, another frame, or a number that is not finite.
    """
    if not message.markers:
        raise MessageError("markers: got none, expected one that deletes the last ones, and one for each mover")
    rows: dict[int, list[float]] = {}
    for marker in message.markers:
        check_frame("markers.header.frame_id", marker.header.frame_id, frame)
        if marker.type == CYLINDER and marker.action == 0:
            place = marker.pose.position
            rows[marker.id] = [place.x, place.y, 0.0, 0.0, marker.scale.x / 2]
    for marker in message.markers:
        if marker.type == ARROW and marker.id in rows and len(marker.points) == 2:
            (tail, tip), row = marker.points, rows[marker.id]
            row[2:4] = (tip.x - tail.x) / AHEAD, (tip.y - tail.y) / AHEAD
    for row in rows.values():
        check_finite("markers", *row)
    return seconds_from_stamp(message.markers[0].header.stamp), np.array(list(rows.values())).reshape(-1, 5)
