"""Impacts: where they were, when they call for a plan, and what plans foresaw of them."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.evaluation.impact_matching import (
    UNMATCHED,
    Prediction,
    judge_impacts,
    match_contacts,
)
from collplan_core.impact import POSES, Impact, measured_impact
from collplan_core.loop.impact_alarm import ImpactAlarm
from collplan_core.paper_planner import foreseen_contacts as foreseen_contacts_module
from collplan_core.paper_planner.costs.model import REBOUND_HORIZON
from collplan_core.paper_planner.foreseen_contacts import foreseen_contacts
from collplan_core.plan import Contacts
from collplan_core.state import State
from scenes import RADIUS, SETTINGS, box, map_of, rotation, unit, world_of

HIT = (1.0, 0.5, 0.0, -0.7, 0.2)
"""Time, point, velocity after."""
SPEED = np.hypot(0.7, 0.2)


def contacts(*rows) -> Contacts:
    table = np.array(rows, dtype=float).reshape(-1, 5)
    return Contacts(table[:, 0], table[:, 1:3], table[:, 3:], np.full((len(table), 2), np.nan))


def hits_of(rows) -> list[Impact]:
    return [Impact(time, np.array([x, y]), np.zeros(2), np.zeros(2), np.array(after)) for time, x, y, *after in rows]


def made(predictions) -> list[Prediction]:
    return [Prediction(when, contacts(*rows)) for when, *rows in predictions]


def foreseen(impacts, *predictions) -> list[bool]:
    return judge_impacts(hits_of(impacts), made(predictions)).foreseen.tolist()


def compared(impacts, *predictions) -> np.ndarray:
    return judge_impacts(hits_of(impacts), made(predictions)).rebounds


def moved(time: float, x: float = 0.0) -> tuple:
    return (time, x + 0.5, *HIT[2:])


def test_an_impact_is_foreseen_by_a_plan_still_in_force():
    table = [
        ([], False),
        ([(0.5, HIT)], True),
        ([(0.86, HIT)], False),  # too late to be a forecast
        ([(0.5, moved(1.14, 0.07))], True),
        ([(0.5, moved(1.16))], False),
        ([(0.5, moved(1.0, 0.09))], False),
        ([(0.5, HIT), (0.7, moved(1.05, 0.02))], True),
        ([(0.5, HIT), (0.9,)], False),  # given up at the last moment
        ([(0.5, HIT), (0.9, HIT)], True),  # confirmed at the last moment
        ([(0.5, HIT), (1.01,)], True),  # made after the impact, says nothing about it
    ]
    for predictions, expected in table:
        assert foreseen([HIT], *predictions) == [expected], predictions
    twice = [HIT, moved(1.1)]
    assert foreseen(twice, (0.5, HIT)) == [True, False]  # one contact stands for one impact
    assert foreseen(twice, (0.5, HIT, moved(1.12))) == [True, True]


places = st.floats(-0.3, 0.3)
hits = st.tuples(st.floats(0.0, 2.0), places, places, st.just(0.0), st.just(0.0))


@given(st.lists(hits, max_size=6), st.lists(hits, max_size=6))
def test_pairs_are_within_tolerance_and_used_once_and_none_is_left(impacts, predicted):
    table, other = (np.array(each, dtype=float).reshape(-1, 5) for each in (impacts, predicted))
    matched = match_contacts(hits_of(impacts), contacts(*predicted))
    used = matched[matched != UNMATCHED]
    assert len(set(used)) == len(used)
    near = np.abs(table[:, None, 0] - other[None, :, 0]) <= 0.15
    near &= np.hypot(*(table[:, None, 1:3] - other[None, :, 1:3]).transpose(2, 0, 1)) <= 0.08
    for i, j in enumerate(matched):
        assert near[i, j] if j != UNMATCHED else not near[i, [k for k in range(len(other)) if k not in used]].any()


def test_the_last_plan_before_an_impact_is_asked_for_its_rebound():
    table = [
        ([(0.5, HIT), (0.9,)], False),  # the last plan gave it up
        ([(0.5,), (0.99, HIT)], True),  # the last plan alone counts
        ([(1.1, HIT)], False),  # made after it
        ([(0.5, (3.0, 0.5, 0.0, 1.0, 0.0), HIT)], True),
    ]
    for predictions, told in table:
        row = compared([HIT], *predictions)[0]
        expected = (0.0, SPEED, SPEED) if told else (np.nan,) * 3
        np.testing.assert_allclose(row, expected, atol=1e-12, err_msg=str(predictions))
    second = (1.6, 0.1, 0.4, 0.3, 0.3)
    rows = compared([HIT, second], (0.5, HIT, second))
    np.testing.assert_allclose(rows[:, :2], [(0.0, SPEED), (0.0, np.hypot(0.3, 0.3))], atol=1e-12)
    assert np.isnan(compared([HIT, second], (0.5, HIT))).tolist() == [[False] * 3, [True] * 3]


@given(angle=st.floats(-np.pi, np.pi), turn=st.floats(-np.pi, np.pi), speed=st.floats(0.01, 2.0))
def test_the_angle_is_that_between_them_whatever_way_both_point(angle, turn, speed):
    row = compared([(1.0, 0.5, 0.0, *(speed * unit(angle + turn)))], (0.5, (1.0, 0.5, 0.0, *unit(angle))))[0]
    np.testing.assert_allclose(row, (abs(turn), 1.0, speed), atol=1e-6)


@given(st.floats(-3.1, 3.1), st.floats(0.05, 3.0), st.floats(-5.0, 5.0), st.floats(-0.6, 0.6))
def test_an_impact_is_at_the_foot_of_the_wall_but_for_what_friction_turns_its_normal_by(angle, strength, x, friction):
    center = np.array([x, -2.0 * x])
    before, change = np.array([0.3, -0.4]), strength * (rotation(angle) @ (1.0, friction))
    contact = measured_impact(7.5, center, before, change, RADIUS, POSES)
    assert contact.time == 7.5
    np.testing.assert_allclose(contact.normal, unit(angle + math.atan(friction)), atol=1e-9)
    np.testing.assert_allclose(contact.point, center - RADIUS * contact.normal, atol=1e-12)
    np.testing.assert_allclose(contact.change, change, atol=1e-12)
    nothing = measured_impact(0.0, center, before, np.zeros(2), RADIUS, POSES)
    assert (nothing.normal.tolist(), nothing.point.tolist()) == ([0.0, 0.0], center.tolist())


TIMES = np.linspace(7.0, 8.0, 64)
E, MU = SETTINGS.rebound.restitution, SETTINGS.rebound.friction


def straight(start, end) -> tuple[np.ndarray, np.ndarray]:
    start, end = np.array(start, dtype=float), np.array(end, dtype=float)
    share = (TIMES - TIMES[0])[:, None] / (TIMES[-1] - TIMES[0])
    return start + share * (end - start), np.broadcast_to(end - start, (len(TIMES), 2)).copy()


def test_by_hand_an_observed_boundary_on_the_way():
    """Wall at x = 0.39: the centre gets to x = 0.3 after 0.6 of the way, the ring touches at x = 0.39."""
    local_map = map_of(world_of([box(0.3 + RADIUS, -4.0, 2.0, 4.0)]))
    found = foreseen_contacts(local_map, TIMES, *straight((0, 0), (0.5, 0.2)), SETTINGS)
    np.testing.assert_allclose(found.times, [7.6], atol=1e-3)
    np.testing.assert_allclose(found.points, [[0.3 + RADIUS, 0.12]], atol=1e-3)
    np.testing.assert_allclose(found.velocities_after, [[-E * 0.5, 0.2 - 0.2 / 3.0]], atol=1e-6)


def test_by_hand_a_predicted_boundary_behind_the_end(monkeypatch):
    """A corridor wall goes on beyond the map at y = 0.2: a plan that ends slanting up meets it just outside."""
    local_map = map_of(world_of([box(-4.0, 0.2 + RADIUS, 4.0, 0.6)]))
    path, velocities = straight((0.0, 0.0), (0.6, 0.15))
    found = foreseen_contacts(local_map, TIMES, path, velocities, SETTINGS)
    # 0.05 m more at 0.15 m/s
    assert len(found.times) == (REBOUND_HORIZON >= 0.05 / 0.15)
    monkeypatch.setattr(foreseen_contacts_module, "REBOUND_HORIZON", 0.4)
    found = foreseen_contacts(local_map, TIMES, path, velocities, SETTINGS)
    np.testing.assert_allclose(found.times, [8.0 + 1 / 3], atol=1e-6)
    np.testing.assert_allclose(found.points, [[0.8, 0.2 + RADIUS]], atol=1e-6)
    np.testing.assert_allclose(found.velocities_after, [[0.6 - MU * (1.0 + E) * 0.15, -E * 0.15]], atol=1e-6)


def state(stamp):
    return State(stamp, np.zeros(2), np.zeros(2), 0.0)


def test_an_impact_is_due_once_with_the_first_pose_as_late_unless_the_poses_break():
    alarm = ImpactAlarm()
    assert not alarm.is_due(state(9.0))
    assert alarm.raised(10.0, local=5.0, pause=0.1) == ""
    assert "0.1" in alarm.raised(11.0, local=5.09, pause=0.1)  # too soon
    due = [alarm.is_due(each) for each in (None, state(9.99), state(10.0), state(10.01))]
    assert due == [False, False, True, False]
    alarm.raised(10.0, 6.0, 0.1)
    alarm.forget()
    assert not alarm.is_due(state(11.0))
