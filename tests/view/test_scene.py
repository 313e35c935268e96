"""The parts of frames: whole thousandths of what they are made of, and nothing that JSON does not know."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.plan import Contacts
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import arena_names, load_world
from collplan_ros.view import scene

QUICK = settings(derandomize=True, deadline=None, max_examples=50)

HALF = 0.0005
LENGTHS = st.floats(-1e3, 1e3)
ANGLES = st.floats(-20.0, 20.0)
NOT_FINITE = st.sampled_from([math.nan, math.inf, -math.inf, 2e6, -1e300])
FLAT_POINTS = st.lists(st.tuples(LENGTHS, LENGTHS), max_size=30)


def states(stamp: float = 0.0):
    return st.builds(
        lambda x, y, vx, vy, yaw: State(stamp, np.array([x, y]), np.array([vx, vy]), yaw),
        LENGTHS, LENGTHS, LENGTHS, LENGTHS, ANGLES,
    )  # fmt: skip


def through_json(part):
    return json.loads(json.dumps(part, allow_nan=False))


@QUICK
@given(FLAT_POINTS)
def test_numbers_are_rounded_to_the_nearest_thousandth(points):
    whole = scene.milli(np.array(points).reshape(-1, 2))
    assert all(type(value) is int for value in whole)
    np.testing.assert_allclose(np.array(whole) / 1000.0, np.array(points).reshape(-1), atol=HALF + 1e-9)


@QUICK
@given(st.lists(LENGTHS, max_size=5), NOT_FINITE, st.lists(LENGTHS, max_size=5))
def test_what_cannot_be_drawn_is_refused_wherever_it_is(before, bad, after):
    with pytest.raises(scene.SceneError):
        scene.milli([*before, bad, *after])
    with pytest.raises(scene.SceneError):
        scene.time_of(math.nan)


@QUICK
@given(states())
def test_the_robot_is_where_it_is(state):
    x, y, yaw, vx, vy = through_json(scene.robot(state))
    np.testing.assert_allclose([x, y, vx, vy], 1e3 * np.hstack([state.position, state.velocity]), atol=0.5 + 1e-6)
    assert abs(yaw) <= 3142
    assert math.cos(yaw / 1000 - state.yaw) == pytest.approx(1.0, abs=1e-6)


@QUICK
@given(states(), st.lists(st.floats(0.05, 4.9), min_size=2, max_size=50), st.floats(-3.0, 3.0))
def test_scan_points_are_as_far_from_the_robot_as_the_beams_say_and_none_where_they_hit_nothing(state, ranges, first):
    ranges = np.array([*ranges, math.inf, math.nan, -math.inf])
    seen = Scan(0.0, first, 6.0 / len(ranges), 0.02, 5.0, ranges)
    points = np.array(through_json(scene.scan(seen, state))).reshape(-1, 2) / 1000.0
    away = np.hypot(*(points - state.position).T)
    np.testing.assert_allclose(away, ranges[:-3], atol=2 * HALF)


def test_a_world_is_drawn_whole():
    for name in (*arena_names(), "serpentine:2", "pillars:1", "random:3"):
        place = load_world(name)
        part = through_json(scene.world(place))
        assert part["bounds"] == scene.milli(place.bounds), name
        assert [len(corners) for corners in part["polygons"]] == [2 * len(corners) for corners in place.polygons], name
        assert len(part["circles"]) == len(place.circles), name


@QUICK
@given(st.lists(st.floats(0.001, 0.5), min_size=1, max_size=20), st.lists(st.tuples(*4 * [LENGTHS]), max_size=4))
def test_a_plan_keeps_its_times_and_contacts(steps, contacts):
    stamp = 100.0
    times = stamp + np.cumsum(steps)
    positions = np.column_stack([times, -times])
    rows = np.array(contacts).reshape(-1, 4)
    touched = Contacts(np.full(len(rows), stamp + 0.25), rows[:, :2], rows[:, 2:], np.full((len(rows), 2), np.nan))
    part = through_json(scene.plan(stamp, times, positions, touched))
    assert len(part["path"]) == 2 * len(part["times"]) == 2 * len(steps)
    np.testing.assert_allclose(np.array(part["times"]) / 1000.0, times - stamp, atol=HALF + 1e-9)
    told = np.array(part["contacts"]).reshape(-1, 5)
    np.testing.assert_allclose(told[:, :4] / 1000.0, rows, atol=HALF + 1e-9)
    assert (told[:, 4] == 250).all()


@QUICK
@given(st.lists(st.floats(-1e6, 1e6) | st.just(math.nan), min_size=1, max_size=20))
def test_rollouts_come_cheapest_first_and_keep_their_cost(costs):
    paths = [np.array([[k, 0.0], [k, 1.0]]) for k in range(len(costs))]
    part = through_json(scene.rollouts(paths, costs))
    for told in part:
        which = told["path"][0] // 1000
        expected = costs[which] if math.isfinite(costs[which]) else 0.0
        assert told["cost"] == pytest.approx(expected, rel=1e-3)
    finite = [costs[told["path"][0] // 1000] for told in part]
    finite = [cost for cost in finite if math.isfinite(cost)]
    assert finite == sorted(finite)


def test_cost_terms_are_told_from_counts():
    values = {
        "planning_time_ms": "12.345", "candidates": "7", "candidates_before_pruning": "9", "foreseen_contacts": "1",
        "hardest_contact": "0.5", "total": "1.23456", "rebound_reward": "-0.25", "strategy": "bounce",
        "risk": "inf",
    }  # fmt: skip
    part = through_json(scene.costs(values))
    assert part == {
        "planning_time": 12.35, "strategy": "bounce", "hardest": 500,
        "terms": {"total": 1.235, "rebound_reward": -0.25},
    }  # fmt: skip


@QUICK
@given(st.floats(0.0, 100.0))
def test_a_node_that_says_nothing_is_silent(age):
    report = scene.NodeReport("/planner_node", 0, "planning", {"plans": "3"}, came=50.0)
    (row,) = through_json(scene.nodes([report], 50.0 + age))
    assert row["silent"] == (50.0 + age - 50.0 > scene.SILENT_AFTER)
    assert abs(row["age"] - age) <= 0.5
