"""Impacts as plans foresaw them and as they came."""

import math

import numpy as np
import pytest

from collplan_core.evaluation.rebound_tracking import ReboundTracker
from collplan_core.plan import Candidates, Contacts, Plan
from collplan_core.state import State

RADIUS, SETTLED = 0.09, 0.06
WALL = 1.0


def state(stamp, x=0.0, velocity=(0.0, 0.0)):
    return State(stamp, np.array([x, 0.0]), np.array(velocity, dtype=float), 0.0)


def plan(stamp, impact_at=None, after=(-0.4, 0.3)):
    contacts = Contacts.none()
    if impact_at is not None:
        contacts = Contacts(np.array([impact_at]), np.array([[WALL, 0.0]]), np.array([after]))
    still, nothing = np.zeros((2, 2)), Candidates(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    times = stamp + np.array([0.0, 1.0])
    return Plan(stamp, times, still, still, contacts, np.zeros(2), np.zeros(2), {}, nothing, 0)


def impact_of(*plans, at=10.0):
    rebounds = ReboundTracker()
    for each in plans:
        rebounds.planned(each)
    rebounds.impact(at, np.array([-1.2, 0.0]), state(at, WALL - RADIUS), RADIUS)
    assert rebounds.moved(state(at + SETTLED - 0.001), SETTLED) is None
    measured = rebounds.moved(state(at + SETTLED, velocity=(-0.4, -0.3)), SETTLED)
    assert rebounds.moved(state(at + 1.0), SETTLED) is None
    return measured


def test_a_foreseen_impact_has_both_rebounds_and_the_angle_between():
    # the plan that was made after the impact, but before it was found, no longer expects it
    impact = impact_of(plan(9.9, impact_at=9.97), plan(9.98))
    np.testing.assert_allclose(impact.point, [WALL, 0.0])
    np.testing.assert_allclose(impact.foreseen, [-0.4, 0.3])
    np.testing.assert_allclose(impact.measured, [-0.4, -0.3])
    assert impact.direction_error == pytest.approx(2 * math.atan2(3, 4))


def test_an_impact_that_no_plan_expected_lately_has_none_foreseen():
    for plans in [(), (plan(9.9),), (plan(9.6, impact_at=9.97), plan(9.9)), (plan(9.9, impact_at=10.3),)]:
        impact = impact_of(*plans)
        assert np.isnan(impact.foreseen).all(), plans
        assert math.isnan(impact.direction_error), plans
        np.testing.assert_allclose(impact.measured, [-0.4, -0.3])


def test_impacts_and_plans_before_a_break_do_not_count():
    rebounds = ReboundTracker()
    rebounds.planned(plan(9.9, impact_at=10.0))
    rebounds.impact(10.0, np.array([-1.2, 0.0]), state(10.0, WALL - RADIUS), RADIUS)
    rebounds.forget()
    assert rebounds.moved(state(11.0), SETTLED) is None
