"""Poses of an odometry in the map, and a base that does not obey."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.control.runaway import why_runaway
from collplan_core.impact import Impact
from collplan_core.parameters import Robot
from collplan_core.poses.felt_touch import change_by_touch
from collplan_core.poses.localised import FrameInMap, moved_impact, moved_state
from collplan_core.state import State
from scenes import unit

numbers = st.floats(-5.0, 5.0)
ROBOT = Robot()


@given(numbers, numbers, st.floats(-9.0, 9.0), numbers, numbers, numbers, numbers)
def test_distances_and_speeds_are_those_of_the_odometry(x, y, yaw, px, py, vx, vy):
    frame = FrameInMap(x, y, yaw)
    states = [State(1.0, np.array(at), np.array([vx, vy]), 0.3) for at in ((px, py), (0.0, 0.0))]
    a, b = (moved_state(state, frame) for state in states)
    assert math.dist(a.position, b.position) == pytest.approx(math.hypot(px, py), abs=1e-9)
    assert math.hypot(*a.velocity) == pytest.approx(math.hypot(vx, vy), abs=1e-9)
    assert math.cos(a.yaw - 0.3 - yaw) == pytest.approx(1.0)


def test_by_hand_a_quarter_turn():
    frame = FrameInMap(1.0, 2.0, math.pi / 2)
    state = moved_state(State(1.0, np.array([1.0, 0.0]), np.array([0.0, 0.5]), math.pi), frame)
    np.testing.assert_allclose(state.position, (1.0, 3.0), atol=1e-12)
    np.testing.assert_allclose(state.velocity, (-0.5, 0.0), atol=1e-12)
    assert state.yaw == pytest.approx(-math.pi / 2)
    hit = Impact(1.0, np.array([0.0, 1.0]), np.array([1.0, 0.0]), np.array([-1.0, 0.0]), np.array([0.5, 0.0]))
    moved = moved_impact(hit, frame)
    np.testing.assert_allclose([moved.point, moved.normal], [(0.0, 2.0), (0.0, 1.0)], atol=1e-12)
    assert moved.speed_into == pytest.approx(hit.speed_into)


@given(st.floats(0.0, 1.2), st.floats(0.0, 3.0), st.floats(0.1, 5.0))
def test_a_robot_that_brakes_as_it_can_obeys(speed_then, stopped_for, patience):
    left = max(0.0, speed_then - ROBOT.max_acceleration * stopped_for)
    assert why_runaway(left, speed_then, stopped_for, patience, ROBOT) == ""


def test_by_hand_when_one_that_does_not_brake_is_told():
    # 1.2 / 1.5 to brake, 0.3 for the lag, 0.5 of patience
    assert why_runaway(1.0, 1.2, 1.59, 0.5, ROBOT) == ""
    assert why_runaway(1.0, 1.2, 1.61, 0.5, ROBOT) == "drives on at 1.00 m/s, 1.6 s after zero"


@given(st.floats(0.05, 2.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.0, 1.0))
def test_a_touch_leaves_no_speed_into_the_obstacle(speed, course, side, restitution):
    velocity, towards = speed * unit(course), unit(side)
    after = velocity + change_by_touch(velocity, towards, restitution)
    assert after @ towards <= 1e-9
    assert np.hypot(*after) <= speed + 1e-9
    head_on = velocity + change_by_touch(velocity, None, restitution)
    np.testing.assert_allclose(head_on, -restitution * velocity, atol=1e-9)


def test_by_hand_a_touch_at_the_side_changes_nothing_of_the_motion_along_it():
    change = change_by_touch(np.array([0.5, 1.0]), np.array([0.0, 1.0]), 0.5)
    np.testing.assert_allclose(change, (0.0, -1.5))
    assert not change_by_touch(np.array([0.5, -1.0]), np.array([0.0, 1.0]), 0.5).any()
    assert not change_by_touch(np.zeros(2), None, 0.5).any()
