"""When an impact calls for a plan outside the planning period."""

import math

import numpy as np
import pytest

from collplan_core.loop.impact_alarm import ImpactAlarm, why_not_now
from collplan_core.state import State

PAUSE = 0.1


def state(stamp):
    return State(stamp, np.zeros(2), np.zeros(2), 0.0)


def test_an_impact_is_due_once_with_the_first_pose_as_late():
    alarm = ImpactAlarm()
    assert not alarm.is_due(state(9.0))
    assert alarm.raised(10.0, local=5.0, pause=PAUSE) == ""
    assert not alarm.is_due(None)
    assert not alarm.is_due(state(9.99))
    assert alarm.is_due(state(10.0))
    assert not alarm.is_due(state(10.01))


def test_impacts_that_follow_too_soon_are_refused_the_next_is_not():
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
def test_an_impact_of_another_time_is_refused_with_the_reason(stamp, now):
    assert "impact" in why_not_now(stamp, now, 0.15)


def test_an_impact_of_the_present_is_plausible():
    assert why_not_now(9.9, 10.0, 0.15) == why_not_now(10.1, 10.0, 0.15) == ""
