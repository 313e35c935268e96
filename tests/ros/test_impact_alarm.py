"""When a hit calls for a plan, and how it is compared with the plans of before."""

import math

import numpy as np
import pytest

from collplan_core.evaluation.rebound_tracking import ReboundTracker
from collplan_core.plan import Candidates, Contacts, Plan
from collplan_core.state import State
from collplan_ros.nodes.impact_alarm import ImpactAlarm, why_not_now

RADIUS, SETTLED, PAUSE = 0.09, 0.06, 0.1
WALL = 1.0


def state(stamp, x=0.0, velocity=(0.0, 0.0)):
    return State(stamp, np.array([x, 0.0]), np.array(velocity, dtype=float), 0.0)


def plan(stamp, hit_at=None, after=(-0.4, 0.3)):
    contacts = Contacts.none()
    if hit_at is not None:
        contacts = Contacts(np.array([hit_at]), np.array([[WALL, 0.0]]), np.array([after]))
    still, nothing = np.zeros((2, 2)), Candidates(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    times = stamp + np.array([0.0, 1.0])
    return Plan(stamp, times, still, still, contacts, np.zeros(2), np.zeros(2), {}, nothing, 0)


def test_a_hit_is_due_once_with_the_first_pose_that_knows_of_it():
    alarm = ImpactAlarm()
    assert not alarm.is_due(state(9.0))
    assert alarm.raised(10.0, local=5.0, pause=PAUSE) == ""
    assert not alarm.is_due(None)
    assert not alarm.is_due(state(9.99))
    assert alarm.is_due(state(10.0))
    assert not alarm.is_due(state(10.01))


def test_hits_that_follow_too_soon_are_refused_the_next_is_not():
    alarm = ImpactAlarm()
    planned = [k for k in range(1024) if not alarm.raised(10.0, 5.0 + k / 1024, pause=0.125)]
    assert planned == list(range(0, 1024, 128))
    assert "expected at least 0.125" in alarm.raised(11.0, 5.9, pause=0.125)


def test_a_break_of_the_poses_ends_the_alarm():
    alarm = ImpactAlarm()
    alarm.raised(10.0, 5.0, PAUSE)
    alarm.forget()
    assert not alarm.is_due(state(11.0))


@pytest.mark.parametrize(("stamp", "now"), [(9.8, 10.0), (10.2, 10.0), (10.0, None), (math.inf, 10.0), (math.nan, 1.0)])
def test_a_hit_of_another_time_is_told_why_it_is_none_of_now(stamp, now):
    assert "impact" in why_not_now(stamp, now, 0.15)


def test_a_hit_of_now():
    assert why_not_now(9.9, 10.0, 0.15) == why_not_now(10.1, 10.0, 0.15) == ""


def hit_of(*plans, at=10.0):
    rebounds = ReboundTracker()
    for each in plans:
        rebounds.planned(each)
    rebounds.impact(at, np.array([-1.2, 0.0]), state(at, WALL - RADIUS), RADIUS)
    assert rebounds.moved(state(at + SETTLED - 0.001), SETTLED) is None
    measured = rebounds.moved(state(at + SETTLED, velocity=(-0.4, -0.3)), SETTLED)
    assert rebounds.moved(state(at + 1.0), SETTLED) is None
    return measured


def test_a_foreseen_hit_has_both_rebounds_and_the_angle_between():
    # the plan that was made after the hit, but before it was found, no longer expects it
    hit = hit_of(plan(9.9, hit_at=9.97), plan(9.98))
    np.testing.assert_allclose(hit.point, [WALL, 0.0])
    np.testing.assert_allclose(hit.foreseen, [-0.4, 0.3])
    np.testing.assert_allclose(hit.measured, [-0.4, -0.3])
    assert hit.direction_error == pytest.approx(2 * math.atan2(3, 4))


@pytest.mark.parametrize("plans", [(), (plan(9.9),), (plan(9.6, hit_at=9.97), plan(9.9)), (plan(9.9, hit_at=10.3),)])
def test_a_hit_that_no_plan_expected_lately_has_none_foreseen(plans):
    hit = hit_of(*plans)
    assert np.isnan(hit.foreseen).all()
    assert math.isnan(hit.direction_error)
    np.testing.assert_allclose(hit.measured, [-0.4, -0.3])


def test_hits_and_plans_of_before_a_break_do_not_count():
    rebounds = ReboundTracker()
    rebounds.planned(plan(9.9, hit_at=10.0))
    rebounds.impact(10.0, np.array([-1.2, 0.0]), state(10.0, WALL - RADIUS), RADIUS)
    rebounds.forget()
    assert rebounds.moved(state(11.0), SETTLED) is None
