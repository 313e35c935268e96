"""When the controller stands still, which plans it refuses, when poses do not join, how old a message is."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from collplan_core.ages import STEP, SenderAge, SmallestDelay
from collplan_core.control.permission import is_blocked, is_relocated, why_refuse_plan, why_shows_itself
from collplan_core.parameters import Limits, LocalMapping, Mocap, Robot, Settings
from collplan_core.plan import timed_path
from collplan_core.scan import Scan
from collplan_core.state import State

LIMITS, LEAP_MARGIN = Limits(), Mocap().leap_margin


def at(stamp: float, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> State:
    return State(stamp, np.array([x, y]), np.zeros(2), yaw)


def test_why_a_plan_is_refused():
    plan = timed_path(2.0, np.linspace(2.0, 3.0, 5), np.zeros((5, 2)), np.zeros((5, 2)))
    for goal_stamp, now, words in (
        (1.9, 2.1, ""),
        (None, 2.1, "goal"),
        (1.9, None, "pose"),
        (2.0, 2.1, "later"),
        (2.5, 2.1, "2.500"),
        (1.9, 2.0 - 1.01 * LIMITS.pose_age, "begins"),
        (1.9, 3.5, "ended"),
    ):
        reason = why_refuse_plan(plan, goal_stamp, now, LIMITS.pose_age)
        assert words in reason, (goal_stamp, now)
        assert bool(words) == bool(reason), (goal_stamp, now)


@given(st.floats(0.0, 2 * math.pi), st.floats(0.0, Robot().max_speed), st.floats(0.001, 0.149))
def test_whatever_the_robot_can_do_joins(direction, speed, dt):
    step = speed * dt
    after = at(5.0 + dt, step * math.cos(direction), step * math.sin(direction))
    assert not is_relocated(at(5.0), after, Robot(), LIMITS, LEAP_MARGIN)


def test_leap_silence_and_clock_set_back_do_not_join():
    for after in [at(5.01, 0.5), at(5.01, 0.0, -0.1), at(5.2), at(4.99), at(5.0, 0.3)]:
        assert is_relocated(at(5.0), after, Robot(), LIMITS, LEAP_MARGIN), after
    for margin in (LEAP_MARGIN, 0.15):
        assert is_relocated(at(5.0), at(5.01, 0.15), Robot(), LIMITS, margin) == (margin < 0.15)


def wall_ahead(distance: float) -> Scan:
    angles = -math.pi + np.arange(360) * 2 * math.pi / 360
    with np.errstate(divide="ignore"):
        ranges = np.where(np.cos(angles) > 1e-6, distance / np.cos(angles), np.inf)
    return Scan(1.0, -math.pi, 2 * math.pi / 360, 0.02, 5.0, np.where(ranges > 5.0, np.inf, ranges))


@given(
    x=st.floats(-1.0, 1.0), y=st.floats(-1.0, 1.0), yaw=st.floats(-3.0, 3.0), off=st.floats(-0.35, 0.35),
    tolerance=st.floats(0.01, 0.2),
)  # fmt: skip
def test_goal_is_blocked_where_the_disc_overlaps_what_is_seen_wherever_it_stands(x, y, yaw, off, tolerance):
    """`off` is the goal's distance in front of the wall; the disc may overlap by less than a centimetre."""
    settings = Settings().with_values({"planner.goal_tolerance": tolerance})
    scan, state, robot = wall_ahead(0.4), at(1.0, x, y, yaw), settings.robot
    ahead = np.array([math.cos(yaw), math.sin(yaw)])
    goal = state.position + (0.4 - off) * ahead
    # the places that are tried are 15 degrees apart, the hits of the scan at most 1 cm
    assume(abs(abs(off) + tolerance - robot.radius + 0.01) > 0.01 * tolerance + 2e-3)
    assert is_blocked(goal, scan, state, settings, LocalMapping()) == (abs(off) + tolerance < robot.radius - 0.01)


def test_a_scan_that_shows_the_robot_itself_is_told_from_a_wall_and_a_corner_beside_it():
    scan, state, radius = wall_ahead(1.0), at(1.0), 0.09
    angles = np.abs(scan.angles)
    for near, where in [
        (angles < 0.2, ""),
        (angles < 1.2, ""),
        (angles < 2.0, ""),
        (np.abs(np.remainder(angles, math.pi / 2) - math.pi / 4) < 0.1, "rim"),
    ]:
        at_rim = why_shows_itself(replace(scan, ranges=np.where(near, 0.1, scan.ranges)), state, radius)
        assert ("rim" in at_rim) == bool(at_rim) == bool(where)
        inside = why_shows_itself(replace(scan, ranges=np.where(near, 0.05, scan.ranges)), state, radius)
        assert "inside the robot, from 0.05 m" in inside
    too_near = replace(scan, ranges=np.where(angles < 0.2, -math.inf, scan.ranges))
    assert "inside" in why_shows_itself(too_near, state, radius)


OLDEST = 0.2
offsets = st.floats(-1e6, 1e6)


@given(offsets, st.lists(st.floats(0.0, 0.5), min_size=1, max_size=10))
def test_ages_are_counted_from_the_smallest_delay_whatever_the_sender_s_clock_says(offset, delays):
    age = SenderAge(OLDEST)
    assert math.isinf(age.measured(offset, 0.0))
    now = 0.0
    for k, delay in enumerate(delays):
        sent = 0.1 * (k + 1)
        now = max(now, sent + delay)  # messages come in order
        # the smallest delay may drift
        assert age.measured(offset + sent, now) == pytest.approx(now - sent, abs=2e-3)


@given(offsets, st.floats(1.5, 100.0), st.floats(0.5, 4.0))
def test_after_a_silence_another_sender_is_measured_anew(offset, silence, behind):
    age = SenderAge(OLDEST)
    age.measured(offset, 0.0)
    assert age.measured(offset + 0.1, 0.1) == pytest.approx(0.0, abs=1e-6)
    # the same one is known
    assert age.measured(offset + 5.1, 5.1) == pytest.approx(0.0, abs=1e-6)
    now = 5.0 + 0.1 + silence
    assert math.isinf(age.measured(offset + now - behind, now))
    assert age.measured(offset + now + 0.05 - behind, now + 0.05) == pytest.approx(0.0, abs=1e-6)


def test_a_step_of_the_senders_clock_spoils_one_message_at_most():
    for step in [-3600.0, 3600.0, -2 * STEP, 2 * STEP]:
        delay, late = SmallestDelay(), []
        for n in range(100):
            delay, age = delay.measured(0.05 * n + (step if n >= 50 else 0.0), 0.05 * n)
            late += [age] if age > 0.01 else []
        assert len(late) == (step < 0), step
