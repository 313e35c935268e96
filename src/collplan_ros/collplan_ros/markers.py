"""What RViz and Foxglove show of a plan: one marker a namespace, each replacing the one before.

Free space, frontiers, predicted boundaries, candidates coloured by cost, the choice, the spline; all in the map frame.
"""

from collections.abc import Iterable

import numpy as np
from geometry_msgs.msg import Point, Pose, Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from collplan_core.local_map import LocalMap
from collplan_core.params import Settings
from collplan_core.plan import Candidates, Plan
from collplan_ros.conversions import header

ARROW_LENGTH = 0.15
"""Drawn length of a predicted boundary [m]."""
VELOCITY_SCALE = 0.1
"""Drawn length of a candidate's velocity per speed [s]."""
LINE_WIDTH = 0.008


def _color(red: float, green: float, blue: float, alpha: float = 1.0) -> ColorRGBA:
    return ColorRGBA(r=red, g=green, b=blue, a=alpha)


FREE_SPACE = _color(0.4, 0.7, 1.0, 0.15)
BORDER = _color(0.2, 0.45, 0.8, 0.8)
FRONTIER = _color(0.1, 0.75, 0.3)
PREDICTED = _color(0.9, 0.3, 0.1)
CHOICE = _color(0.85, 0.1, 0.6)
SPLINE = _color(0.1, 0.1, 0.1)


def plan_markers(local_map: LocalMap, plan: Plan, settings: Settings) -> MarkerArray:
    """All markers of one cycle, in the map frame at the plan's stamp."""
    head = header(plan.stamp, settings.frames.map)
    markers = [
        _free_space(head, local_map),
        _line_strip(head, "border", np.vstack([local_map.points, local_map.points[:1]]), BORDER, LINE_WIDTH / 2),
        _line_list(head, "frontiers", local_map.segments.reshape(-1, 2), [FRONTIER] * (2 * len(local_map.segments))),
        _predicted(head, local_map),
        *_candidates(head, plan.candidates),
        *_choice(head, plan, settings.robot.radius),
        _line_strip(head, "spline", plan.positions, SPLINE, LINE_WIDTH),
    ]
    return MarkerArray(markers=markers)


def cost_colors(costs: np.ndarray) -> list[ColorRGBA]:
    """From green, the cheapest, over yellow to red, the dearest; by rank, because penalised costs lie far apart."""
    share = np.argsort(np.argsort(costs, kind="stable"), kind="stable") / max(len(costs) - 1, 1)
    return [_color(min(1.0, 2 * s), min(1.0, 2 - 2 * s), 0.0, 0.9) for s in share.tolist()]


def _free_space(head: Header, local_map: LocalMap) -> Marker:
    """F as the triangles of its star: the centre and two neighbouring ends each."""
    ends = local_map.points
    center = np.broadcast_to(local_map.position, ends.shape)
    corners = np.stack([center, ends, np.roll(ends, -1, axis=0)], axis=1).reshape(-1, 2)
    return _marker(head, "free_space", Marker.TRIANGLE_LIST, Vector3(x=1.0, y=1.0, z=1.0), corners, FREE_SPACE)


def _predicted(head: Header, local_map: LocalMap) -> Marker:
    """E as arrows into unseen space: a shaft and two barbs each, in one list so that none is left behind."""
    origins, tangents = local_map.predicted[:, :2], local_map.predicted[:, 2:]
    sides = np.column_stack([-tangents[:, 1], tangents[:, 0]])
    tips = origins + ARROW_LENGTH * tangents
    barbs = [tips - 0.25 * ARROW_LENGTH * (tangents + sign * 0.5 * sides) for sign in (-1.0, 1.0)]
    ends = np.stack([origins, tips, barbs[0], tips, barbs[1], tips], axis=1).reshape(-1, 2)
    return _line_list(head, "predicted", ends, [PREDICTED] * len(ends))


def _candidates(head: Header, candidates: Candidates) -> Iterable[Marker]:
    """Each candidate's velocity as a line from its position, the cheapest last and so on top; those at rest as dots."""
    order = np.argsort(-candidates.costs, kind="stable")
    colors = cost_colors(candidates.costs)
    tips = candidates.positions + VELOCITY_SCALE * candidates.velocities
    lines = np.stack([candidates.positions, tips], axis=1)[order].reshape(-1, 2)
    yield _line_list(head, "candidates", lines, [colors[i] for i in order for _ in range(2)], LINE_WIDTH / 2)
    at_rest = [i for i in order if not candidates.velocities[i].any()]
    size = Vector3(x=2 * LINE_WIDTH, y=2 * LINE_WIDTH, z=0.0)
    dots = _marker(head, "candidates_at_rest", Marker.POINTS, size, candidates.positions[at_rest])
    dots.colors = [colors[i] for i in at_rest]
    yield dots


def _choice(head: Header, plan: Plan, radius: float) -> Iterable[Marker]:
    """The robot's disc at the aim p_s, and the velocity v_s there."""
    angles = np.linspace(0.0, 2 * np.pi, 33)
    disc = plan.aim + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    yield _line_strip(head, "choice", disc, CHOICE, LINE_WIDTH)
    ends = np.stack([plan.aim, plan.aim + 2 * VELOCITY_SCALE * plan.aim_velocity])
    yield _line_list(head, "choice_velocity", ends, [CHOICE] * 2)


def _line_strip(head: Header, namespace: str, points: np.ndarray, color: ColorRGBA, width: float) -> Marker:
    return _marker(head, namespace, Marker.LINE_STRIP, Vector3(x=width), points, color)


def _line_list(
    head: Header, namespace: str, points: np.ndarray, colors: list[ColorRGBA], width: float = LINE_WIDTH
) -> Marker:
    marker = _marker(head, namespace, Marker.LINE_LIST, Vector3(x=width), points)
    marker.colors = colors
    return marker


def _marker(
    head: Header, namespace: str, kind: int, scale: Vector3, points: np.ndarray, color: ColorRGBA | None = None
) -> Marker:
    """A marker of points (n, 2) [m]; without any it clears what was there, as RViz refuses empty lists."""
    return Marker(
        header=head,
        ns=namespace,
        id=0,
        type=kind,
        action=Marker.ADD if len(points) else Marker.DELETE,
        pose=Pose(),
        scale=scale,
        color=color or _color(1.0, 1.0, 1.0),
        points=[Point(x=x, y=y, z=0.0) for x, y in np.asarray(points, dtype=float).tolist()],
    )
