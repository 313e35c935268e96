"""Markers of points and lines: one per namespace, each replacing the one before."""

import numpy as np
from geometry_msgs.msg import Point, Pose, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker

LINE_WIDTH = 0.008
"""Default width of lines [m]."""
ARROW_ENDS = 6
"""Number of points that one arrow of `arrow_lines` is made of."""


def color(red: float, green: float, blue: float, alpha: float = 1.0) -> ColorRGBA:
    """Colour of components from 0 to 1."""
    return ColorRGBA(r=red, g=green, b=blue, a=alpha)


def line_strip(head: Header, namespace: str, points: np.ndarray, line_color: ColorRGBA, width: float) -> Marker:
    """Marker of a polyline through points (n, 2) [m]."""
    return marker(head, namespace, Marker.LINE_STRIP, Vector3(x=width), points, line_color)


def line_list(
    head: Header, namespace: str, points: np.ndarray, colors: list[ColorRGBA], width: float = LINE_WIDTH
) -> Marker:
    """Marker of n line segments with ends (2n, 2) [m] and a colour for each end."""
    lines = marker(head, namespace, Marker.LINE_LIST, Vector3(x=width), points)
    lines.colors = colors
    return lines


def lines_of_one_color(
    head: Header, namespace: str, points: np.ndarray, line_color: ColorRGBA, width: float = LINE_WIDTH
) -> Marker:
    """Marker of n line segments with ends (2n, 2) [m] in one colour."""
    return marker(head, namespace, Marker.LINE_LIST, Vector3(x=width), points, line_color)


def dots(head: Header, namespace: str, points: np.ndarray, size: float, dot_color: ColorRGBA) -> Marker:
    """Marker of squares of this size [m] at points (n, 2) [m]."""
    return marker(head, namespace, Marker.POINTS, Vector3(x=size, y=size), points, dot_color)


def circle(center: np.ndarray, radius: float) -> np.ndarray:
    """(33, 2) points of a closed circle [m] around a centre (2,) [m]."""
    angles = np.linspace(0.0, 2 * np.pi, 33)
    return center + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def fan(center: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """(3 n, 2) corners of the triangles between a centre (2,) and neighbours of a closed border (n, 2) [m]."""
    return np.stack([np.broadcast_to(center, ends.shape), ends, np.roll(ends, -1, axis=0)], axis=1).reshape(-1, 2)


def arrow_lines(origins: np.ndarray, tips: np.ndarray, barb: float) -> np.ndarray:
    """(n * ARROW_ENDS, 2) ends of line segments that draw arrows from origins (n, 2) to tips (n, 2), barbs `barb` long.

    One marker of lines replaces all arrows of the cycle before; markers of type ARROW would have to be deleted singly.
    """
    along = tips - origins
    length = np.hypot(along[:, 0], along[:, 1])[:, None]
    tangents = np.divide(along, length, out=np.zeros_like(along), where=length > 0.0)
    sides = np.column_stack([-tangents[:, 1], tangents[:, 0]])
    left, right = (tips - barb * (tangents + sign * 0.5 * sides) for sign in (-1.0, 1.0))
    return np.stack([origins, tips, left, tips, right, tips], axis=1).reshape(-1, 2)


def marker(
    head: Header, namespace: str, kind: int, scale: Vector3, points: np.ndarray, one_color: ColorRGBA | None = None
) -> Marker:
    """Marker of points (n, 2) [m]; without points it deletes the old marker, because RViz refuses empty lists."""
    return Marker(
        header=head,
        ns=namespace,
        id=0,
        type=kind,
        action=Marker.ADD if len(points) else Marker.DELETE,
        pose=Pose(),
        scale=scale,
        color=one_color or color(1.0, 1.0, 1.0),
        points=[Point(x=x, y=y, z=0.0) for x, y in np.asarray(points, dtype=float).tolist()],
    )
