"""Markers of a planning cycle for RViz and Foxglove, in the map frame: one per namespace, replaced in each cycle.

Every strategy shows robot, goal and scan, free space, frontiers, predicted boundaries, the cheapest candidates coloured
by cost, the choice, the plan, its foreseen contacts and rebounds; time-to-goal strategies also rollouts
and memory.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Vector3
from std_msgs.msg import ColorRGBA, Header
from visualization_msgs.msg import Marker, MarkerArray

from collplan_core.local_map import LocalMap
from collplan_core.parameters import Settings
from collplan_core.plan import Candidates, Contacts, Plan
from collplan_core.time_to_goal_planner.boundary_memory.working import RememberedBoundaries
from collplan_ros.markers.shapes import (
    LINE_WIDTH,
    arrow_lines,
    circle,
    color,
    dots,
    fan,
    line_list,
    line_strip,
    lines_of_one_color,
    marker,
)
from collplan_ros.messages import cloud_reading as clouds
from collplan_ros.messages.conversions import header
from collplan_ros.messages.planner_clouds import cheapest, seen_layers

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


BARB = 0.04
"""Drawn length of an arrow's barb [m]."""
VELOCITY_SCALE = 0.1
"""Drawn length of a candidate's velocity, per speed [s]."""
REBOUND_SCALE = 0.25
"""Drawn length of a velocity after a contact, per speed [s]."""

FREE_SPACE = color(0.4, 0.7, 1.0, 0.15)
BORDER = color(0.2, 0.45, 0.8, 0.8)
FRONTIER = color(0.1, 0.75, 0.3)
PREDICTED = color(0.9, 0.3, 0.1)
CHOICE = color(0.85, 0.1, 0.6)
PLAN = color(0.1, 0.1, 0.1)
FORESEEN = color(0.95, 0.65, 0.0)
ROLLOUT = color(0.2, 0.5, 0.9, 0.5)
REMEMBERED = color(0.25, 0.25, 0.3)
INFERRED = color(0.25, 0.25, 0.3, 0.25)


def plan_markers(
    local_map: LocalMap,
    plan: Plan,
    remembered: RememberedBoundaries | None,
    goal: np.ndarray,
    settings: Settings,
) -> MarkerArray:
    """All markers of one cycle, in the map frame at the plan's stamp; the goal (2,) is what the plan leads to [m].

    `remembered` is None where the planner remembers no boundaries.
    """
    head = header(plan.stamp, settings.frames.map)
    markers = [
        *_layers(head, local_map, remembered, settings),
        *_candidates(head, plan.candidates),
        *_choice(head, plan, settings.robot.radius),
        line_strip(head, "plan", plan.positions, PLAN, LINE_WIDTH),
        *_contacts(head, plan.contacts),
        lines_of_one_color(head, "rollouts", _strips_as_lines(plan.candidates.paths), ROLLOUT, LINE_WIDTH / 4),
        *scene_markers(head, local_map, plan, goal, settings),
    ]
    return MarkerArray(markers=markers)


def cost_colors(costs: np.ndarray) -> list[ColorRGBA]:
    """Colours by rank of the costs (n,), green over yellow to red; by rank, because penalised costs lie far apart."""
    share = np.argsort(np.argsort(costs, kind="stable"), kind="stable") / max(len(costs) - 1, 1)
    return [color(min(1.0, 2 * s), min(1.0, 2 - 2 * s), 0.0, 0.9) for s in share.tolist()]


def _layers(
    head: Header, local_map: LocalMap, remembered: RememberedBoundaries | None, settings: Settings
) -> Iterable[Marker]:
    """Yields the markers of planner/seen; empty ones, which clear the old, where nothing is remembered."""
    layers = seen_layers(local_map, remembered, settings)
    border, nothing = layers[clouds.FREE_SPACE], np.zeros((0, 2))
    # a fan of triangles: the centre and two neighbouring ends each
    corners, whole = fan(local_map.position, border), Vector3(x=1.0, y=1.0, z=1.0)
    yield marker(head, "free_space", Marker.TRIANGLE_LIST, whole, corners, FREE_SPACE)
    yield line_strip(head, "border", np.vstack([border, border[:1]]), BORDER, LINE_WIDTH / 2)
    yield lines_of_one_color(head, "frontiers", layers[clouds.FRONTIERS], FRONTIER)
    arrows = arrow_lines(layers[clouds.PREDICTED][::2], layers[clouds.PREDICTED][1::2], BARB)
    yield lines_of_one_color(head, "predicted", arrows, PREDICTED)
    yield lines_of_one_color(head, "remembered", layers.get(clouds.REMEMBERED, nothing), REMEMBERED)
    # each line as wide as its piece is long
    solid = layers.get(clouds.INFERRED, nothing)
    yield lines_of_one_color(head, "inferred", solid, INFERRED, settings.remembered.spacing)


def _strips_as_lines(strips: Sequence[np.ndarray]) -> np.ndarray:
    """(2n, 2) ends of all line segments of the strips, each a polyline (k, 2)."""
    return np.concatenate([np.zeros((0, 2)), *(np.repeat(strip, 2, axis=0)[1:-1] for strip in strips)])


def _candidates(head: Header, candidates: Candidates) -> Iterable[Marker]:
    """Candidates: a velocity is a line from its position, the cheapest drawn last and on top; at rest, a dot."""
    order = cheapest(candidates)[::-1]
    positions, velocities = candidates.positions[order], candidates.velocities[order]
    colors = cost_colors(candidates.costs[order])
    lines = np.stack([positions, positions + VELOCITY_SCALE * velocities], axis=1).reshape(-1, 2)
    yield line_list(head, "candidates", lines, [each for each in colors for _ in range(2)], LINE_WIDTH / 2)
    at_rest = np.flatnonzero(~velocities.any(axis=1))
    resting = dots(head, "candidates_at_rest", positions[at_rest], 2 * LINE_WIDTH, color(1.0, 1.0, 1.0))
    resting.colors = [colors[i] for i in at_rest]
    yield resting


def _choice(head: Header, plan: Plan, radius: float) -> Iterable[Marker]:
    """The robot's disc at the aim p_s, and the velocity v_s there."""
    yield line_strip(head, "choice", circle(plan.aim, radius), CHOICE, LINE_WIDTH)
    ends = np.stack([plan.aim, plan.aim + 2 * VELOCITY_SCALE * plan.aim_velocity])
    yield lines_of_one_color(head, "choice_velocity", ends, CHOICE)


def _contacts(head: Header, contacts: Contacts) -> Iterable[Marker]:
    """Foreseen contacts of the plan and the velocities after them."""
    yield dots(head, "foreseen_contacts", contacts.points, 3 * LINE_WIDTH, FORESEEN)
    tips = contacts.points + REBOUND_SCALE * contacts.velocities_after
    yield lines_of_one_color(head, "foreseen_rebounds", arrow_lines(contacts.points, tips, BARB), FORESEEN)
