"""Markers of what is there: robot, goal and scan, in the map frame, so that they are seen without any transform."""

from collections.abc import Iterable

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Vector3
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from collplan_core.local_map import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_ros.markers.shapes import LINE_WIDTH, circle, color, dots, fan, line_strip, marker

ROBOT = color(0.15, 0.3, 0.55, 0.6)
GOAL = color(0.1, 0.6, 0.2)
SCAN = color(0.8, 0.0, 0.0)
SHOWN = Duration(sec=1)
"""Time for which robot and scan are shown where no plan follows, so that outdated ones do not stay."""


def scene_markers(
    head: Header, local_map: LocalMap, plan: Plan, goal: np.ndarray, settings: Settings
) -> Iterable[Marker]:
    """The robot's disc where the plan begins, the goal (2,) [m] with its tolerance, and where the beams hit."""
    disc = circle(plan.positions[0], settings.robot.radius)
    robot = marker(
        head, "robot", Marker.TRIANGLE_LIST, Vector3(x=1.0, y=1.0, z=1.0), fan(plan.positions[0], disc), ROBOT
    )
    robot.lifetime = SHOWN
    yield robot
    yield line_strip(head, "goal", circle(goal, settings.planner.goal_tolerance), GOAL, LINE_WIDTH)
    scan = dots(head, "scan", scan_points(local_map), 1.5 * LINE_WIDTH, SCAN)
    scan.lifetime = SHOWN
    yield scan


def scan_points(local_map: LocalMap) -> np.ndarray:
    """(n, 2) points that the beams of the local map's scan hit [m]."""
    x, y, first, step = local_map.view_from
    hits = np.flatnonzero(np.isfinite(local_map.view) & (local_map.view > 0.0))
    bearings, ranges = first + step * hits, local_map.view[hits]
    return np.array([x, y]) + ranges[:, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
