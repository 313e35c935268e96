"""Markers from a real cycle: what they show, that they replace each other, and what RViz asks of them."""

from dataclasses import replace
from importlib.resources import files

import numpy as np
import pytest
import yaml
from visualization_msgs.msg import Marker

from collplan_core.evaluation.rebound_tracking import MeasuredImpact
from collplan_core.local_map import build_local_map
from collplan_core.parameters import Settings
from collplan_core.plan import Candidates, Contacts
from collplan_core.planners import PAPER, ROLLOUTS, planner_for
from collplan_core.state import State
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.markers.plan_markers import (
    ARROW_LENGTH,
    FORESEEN,
    MEASURED,
    MOST_CANDIDATES,
    REBOUND_SCALE,
    cost_colors,
    plan_markers,
)
from collplan_ros.markers.shapes import ARROW_ENDS
from collplan_ros.messages.qos import EVERY_UNRELIABLE
from collplan_ros.recording.recorded_topics import recorded_topics
from fake_robot import LIDAR, hall

SETTINGS = Settings()
GOAL = np.array([2.0, 0.0])
KINDS = {"SetGoal": "PoseStamped"}
"""What RViz's tools send; displays are named like what they show."""
FIXED_SCALE = {Marker.TRIANGLE_LIST: ("x", "y", "z"), Marker.POINTS: ("x", "y")}


@pytest.fixture(scope="module")
def cycle():
    state = State(3.25, np.array([0.1, 0.2]), np.array([0.3, 0.0]), 0.4)
    local_map = build_local_map(simulate_scan(hall(0.1), state, LIDAR), state, SETTINGS.robot, SETTINGS.local_map)
    plan, memory = planner_for("harness").plan(None, local_map, state, GOAL, SETTINGS)
    return local_map, plan, PAPER.boundaries(memory)


@pytest.fixture(scope="module")
def markers(cycle):
    return by_namespace(cycle)


@pytest.fixture(scope="module")
def rollouts():
    """The second cycle of a strategy that remembers: map, plan, remembered boundaries, settings."""
    settings = SETTINGS.with_values({"planner.strategy": "bounce", "time_to_goal.proposals": 100})
    memory = None
    for stamp in (3.25, 3.30):
        state = State(stamp, np.array([0.1, 0.2]), np.array([0.3, 0.0]), 0.4)
        local_map = build_local_map(simulate_scan(hall(0.1), state, LIDAR), state, settings.robot, settings.local_map)
        plan, memory = planner_for("bounce").plan(memory, local_map, state, GOAL, settings)
    return local_map, plan, ROLLOUTS.boundaries(memory), settings


def by_namespace(cycle, hit=None, settings=SETTINGS):
    return {marker.ns: marker for marker in plan_markers(*cycle, hit, GOAL, settings).markers}


def points(marker):
    return np.array([(p.x, p.y) for p in marker.points])


def test_one_marker_a_namespace_so_that_each_replaces_the_last(cycle):
    made = plan_markers(*cycle, None, GOAL, SETTINGS).markers
    assert len({m.ns for m in made}) == len(made)
    assert {m.id for m in made} == {0}
    assert {m.header.frame_id for m in made} == {"map"}
    assert {(m.header.stamp.sec, m.header.stamp.nanosec) for m in made} == {(3, 250_000_000)}


def test_free_space_is_covered_by_its_triangles(cycle, markers):
    triangles = points(markers["free_space"]).reshape(-1, 3, 2)
    (a, b), (c, d) = (triangles[:, 1] - triangles[:, 0]).T, (triangles[:, 2] - triangles[:, 0]).T
    x, y = cycle[0].border_points.T
    shoelace = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert 0.5 * (a * d - b * c).sum() == pytest.approx(shoelace, rel=1e-9)


def test_lines_are_where_the_records_say(cycle, markers):
    local_map, plan, _ = cycle
    np.testing.assert_array_equal(points(markers["frontiers"]).reshape(-1, 4), local_map.segments)
    np.testing.assert_array_equal(points(markers["plan"]), plan.positions)
    shafts = points(markers["predicted"]).reshape(-1, 6, 2)[:, :2]
    np.testing.assert_allclose(shafts[:, 0], local_map.predicted[:, :2])
    np.testing.assert_allclose((shafts[:, 1] - shafts[:, 0]) / ARROW_LENGTH, local_map.predicted[:, 2:], atol=1e-9)
    np.testing.assert_allclose(points(markers["choice_velocity"])[0], plan.aim)
    radii = np.hypot(*(points(markers["choice"]) - plan.aim).T)
    np.testing.assert_allclose(radii, SETTINGS.robot.radius)


def test_candidates_are_coloured_by_cost_the_cheapest_on_top(cycle, markers):
    lines = markers["candidates"]
    assert len(lines.points) == len(lines.colors) == 2 * len(cycle[1].candidates.costs)
    assert (lines.colors[-1].r, lines.colors[-1].g) == (0.0, 1.0)
    assert (lines.colors[0].r, lines.colors[0].g) == (1.0, 0.0)
    best = cycle[1].candidates.positions[cycle[1].candidates.costs.argmin()]
    np.testing.assert_allclose(points(lines)[-2], best)
    dots = markers["candidates_at_rest"]
    assert len(dots.points) == len(dots.colors) == (~cycle[1].candidates.velocities.any(axis=1)).sum() > 0


def test_cost_colors_of_one_candidate():
    (only,) = cost_colors(np.array([3.0]))
    assert (only.r, only.g) == (0.0, 1.0)


def test_every_size_that_rviz_uses_is_positive(markers):
    for marker in markers.values():
        for axis in FIXED_SCALE.get(marker.type, ("x",)):
            assert getattr(marker.scale, axis) > 0.0, marker.ns


def test_what_is_gone_is_deleted(cycle):
    local_map, plan, remembered = cycle
    bare = replace(local_map, predicted=np.zeros((0, 4)), segments=np.zeros((0, 4)))
    made = by_namespace((bare, plan, remembered))
    assert made["predicted"].action == made["frontiers"].action == Marker.DELETE
    assert made["plan"].action == Marker.ADD


def test_what_another_strategy_showed_is_deleted(cycle, rollouts):
    *shown, settings = rollouts
    only_rollouts = ("rollouts", "remembered", "inferred")
    now, then = by_namespace(cycle), by_namespace(shown, None, settings)
    assert now.keys() == then.keys()
    assert {now[name].action for name in only_rollouts} == {Marker.DELETE}
    assert {then[name].action for name in only_rollouts} == {Marker.ADD}


def test_rollouts_and_memory_are_where_the_records_say(rollouts):
    *shown, settings = rollouts
    _, plan, remembered = shown
    paths = plan.candidates.paths
    made = by_namespace(shown, None, settings)
    np.testing.assert_array_equal(points(made["plan"]), plan.positions)
    lines = points(made["rollouts"]).reshape(-1, 4)
    assert len(lines) == sum(len(path) - 1 for path in paths) > 0
    np.testing.assert_array_equal(lines[: len(paths[0]) - 1, 2:], paths[0][1:])
    np.testing.assert_array_equal(points(made["remembered"]).reshape(-1, 4), remembered.pieces)
    depths = np.linalg.norm(np.diff(points(made["inferred"]).reshape(-1, 2, 2), axis=1), axis=2)
    np.testing.assert_allclose(depths, settings.remembered.inferred_depth - 2 * settings.robot.radius)
    assert made["rollouts"].scale.x < made["plan"].scale.x


def test_of_many_candidates_the_cheapest_are_shown(cycle):
    local_map, plan, remembered = cycle
    places, costs = np.arange(4.0 * MOST_CANDIDATES).reshape(-1, 2), np.arange(2.0 * MOST_CANDIDATES)[::-1]
    many = replace(plan, candidates=Candidates(places, np.ones_like(places), costs))
    shown = points(by_namespace((local_map, many, remembered))["candidates"])
    assert len(shown) == 2 * MOST_CANDIDATES
    np.testing.assert_array_equal(shown[::2], places[MOST_CANDIDATES:])


def test_foreseen_contacts_have_an_arrow_each(cycle):
    local_map, plan, remembered = cycle
    contacts = Contacts(np.array([4.0, 5.0]), np.array([[0.4, 0.1], [1.0, 0.9]]), np.array([[0.0, 0.5], [-0.4, 0.3]]))
    made = by_namespace((local_map, replace(plan, contacts=contacts), remembered))
    np.testing.assert_array_equal(points(made["foreseen_contacts"]), contacts.points)
    shafts = points(made["foreseen_rebounds"]).reshape(2, ARROW_ENDS, 2)[:, :2]
    np.testing.assert_allclose(np.diff(shafts, axis=1)[:, 0], REBOUND_SCALE * contacts.velocities_after)


@pytest.mark.parametrize("foreseen", [True, False])
def test_the_last_hit_is_shown_as_foreseen_and_as_measured(cycle, foreseen):
    expected = np.array([0.0, 0.5]) if foreseen else np.full(2, np.nan)
    hit = MeasuredImpact(3.2, np.array([0.3, 0.2]), expected, np.array([0.1, 0.4]))
    shown = by_namespace(cycle, hit)["rebound"]
    shafts = points(shown).reshape(-1, ARROW_ENDS, 2)[:, :2]
    velocities = [expected, hit.measured] if foreseen else [hit.measured]
    np.testing.assert_allclose(shafts[:, 0], np.tile(hit.point, (len(velocities), 1)))
    np.testing.assert_allclose(np.diff(shafts, axis=1)[:, 0], REBOUND_SCALE * np.array(velocities))
    colors = [FORESEEN, MEASURED] if foreseen else [MEASURED]
    assert shown.colors[::ARROW_ENDS] == colors


def test_robot_goal_and_scan_are_where_they_are(markers):
    """All that RViz needs to show them is the frame map."""
    corners = points(markers["robot"]).reshape(-1, 3, 2)
    np.testing.assert_allclose(corners[:, 0], np.tile([0.1, 0.2], (len(corners), 1)))
    np.testing.assert_allclose(np.hypot(*(corners[:, 1] - [0.1, 0.2]).T), SETTINGS.robot.radius)
    np.testing.assert_allclose(np.hypot(*(points(markers["goal"]) - GOAL).T), SETTINGS.planner.goal_tolerance)
    state = State(3.25, np.array([0.1, 0.2]), np.array([0.3, 0.0]), 0.4)
    scan = simulate_scan(hall(0.1), state, LIDAR)
    bearings = state.yaw + scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    ends = state.position + scan.ranges[:, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    np.testing.assert_allclose(points(markers["scan"]), ends[np.isfinite(scan.ranges)], atol=1e-9)


def test_what_moves_is_not_shown_for_long(markers):
    assert {name for name, marker in markers.items() if marker.lifetime.sec} == {"robot", "scan"}


def rviz_displays():
    text = (files("collplan_ros") / "rviz" / "collplan.rviz").read_text()
    manager = yaml.safe_load(text)["Visualization Manager"]
    assert manager["Global Options"]["Fixed Frame"] == "map"
    return [shown for shown in [*manager["Displays"], *manager["Tools"]] if "Topic" in shown]


def test_rviz_shows_the_graph_and_hears_what_is_sent():
    displays = {shown["Topic"]["Value"]: shown for shown in rviz_displays()}
    assert {"planner/markers", "scan", "plan", "mocap/odom", "goal_pose"} <= displays.keys()
    published = recorded_topics(SETTINGS)
    for name, shown in displays.items():
        kind = shown["Class"].partition("/")[2]
        assert published[name].kind.__name__ == KINDS.get(kind, kind)
        wants_all = shown["Topic"]["Reliability Policy"] == "Reliable"
        assert not wants_all or published[name].qos != EVERY_UNRELIABLE, name
    assert displays["planner/markers"]["Topic"]["Durability Policy"] == "Transient Local"


def test_rviz_shows_nothing_at_first_that_needs_a_transform():
    assert [shown["Class"] for shown in rviz_displays() if shown.get("Enabled") is False] == [
        "rviz_default_plugins/LaserScan"
    ]
