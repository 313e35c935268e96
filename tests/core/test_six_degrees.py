"""Heading, tilt and height of a measured pose: what a robot on a floor cannot do is refused."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Settings
from collplan_core.sensing.pose_filter import FRESH, PoseSample, check_pose_fields, filter_pose
from collplan_core.sensing.six_degrees import tilt_of

FEW = settings(derandomize=True, deadline=None, max_examples=30)
SETTINGS = Settings()
PERIOD = 0.01
SPEED = 0.6


def feed(poses, memory=FRESH, begin=0, config=SETTINGS):
    """A result for each (yaw, height, tilt), 10 ms apart on the way along x, and the memory after the last."""
    results = []
    for k, (yaw, height, tilt) in enumerate(poses, begin):
        stamp = PERIOD * k
        sample = PoseSample(stamp, np.array([SPEED * stamp, 0.0]), math.remainder(yaw, math.tau), height, tilt)
        result, memory = filter_pose(memory, sample, stamp, config)
        results.append(result)
    return results, memory


def upright(n, yaw=0.0, height=0.1):
    return [(yaw, height, 0.0)] * n


def refusals(results):
    return {result.refused for result in results}


def test_a_heading_that_leaps_is_refused_for_as_long_as_it_lasts():
    for angle in [math.pi / 2, -math.pi / 2, math.pi, -2.0]:
        _, memory = feed(upright(30, yaw=2.8))
        results, memory = feed(upright(1000, yaw=2.8 + angle), memory, 30)
        assert refusals(results) == {"yaw"}, angle
        results, _ = feed(upright(5, yaw=2.8), memory, 1030)
        assert refusals(results) == {""}, angle


@given(angle=st.floats(0.3, 1.5))
@FEW
def test_a_smaller_leap_is_refused_until_the_robot_can_have_turned_so_far(angle):
    _, memory = feed(upright(30))
    results, _ = feed(upright(40, yaw=angle), memory, 30)
    taken = [not result.refused for result in results]
    first = taken.index(True)
    assert first >= 1
    assert PERIOD * first <= SETTINGS.limits.pose_age
    assert all(taken[first:])


def test_a_rolling_rim_spins_no_faster_and_no_quarter_turn_is_motion_in_a_silence_that_is_driven_through():
    robot, mocap = SETTINGS.robot, SETTINGS.mocap
    assert (1.0 - robot.inertia_factor) * robot.max_speed / robot.radius < mocap.max_spin
    assert mocap.max_spin * SETTINGS.limits.pose_age + mocap.yaw_margin < math.pi / 2


def test_turned_while_it_was_off_the_floor_or_unseen_is_a_relocation():
    for fault, reason in [(None, ""), ((0.0, 0.1, 0.5), "tilt"), ((0.0, 0.3, 0.0), "height")]:
        _, memory = feed(upright(30))
        if reason:
            results, memory = feed([fault] * 55, memory, 30)
            assert refusals(results) == {reason}, (fault, reason)
        results, _ = feed(upright(70, yaw=math.pi), memory, 85)
        assert refusals(results[:50]) == {"yaw"}, (fault, reason)
        assert [k for k, result in enumerate(results) if result.relocated] == [50], (fault, reason)
        assert results[50].carried, (fault, reason)
        assert refusals(results[50:]) == {""}, (fault, reason)


def test_a_flip_after_a_bump_that_tips_it_for_a_moment_is_none():
    _, memory = feed(upright(30))
    _, memory = feed([(0.0, 0.1, 0.5)] * 20, memory, 30)
    results, _ = feed(upright(300, yaw=math.pi), memory, 50)
    assert refusals(results) == {"yaw"}


@given(leap=st.floats(0.3, 5.0), turn=st.floats(1.6, math.pi))
@FEW
def test_carried_and_turned_is_a_relocation_however_near(leap, turn):
    """By 0.5 m is in reach 0.31 s later."""
    _, memory = feed(upright(30))
    results = []
    for k in range(30, 100):
        sample = PoseSample(PERIOD * k, np.array([SPEED * PERIOD * 29 + leap, 0.0]), turn, 0.1)
        result, memory = filter_pose(memory, sample, PERIOD * k, SETTINGS)
        results.append(result)
    assert [k for k, result in enumerate(results) if result.carried] == [50]
    assert results[-1].state is not None


def test_a_flip_behind_a_short_occlusion_is_none():
    _, memory = feed(upright(30))
    results, _ = feed(upright(300, yaw=math.pi), memory, 30 + 30)
    assert refusals(results) == {"yaw"}


def test_a_flip_is_one_wherever_the_markers_sit():
    """Turned by pi about markers ahead of it, the computed centre leaps by twice that: no relocation."""
    for offset in [0.0, 0.1, -0.3]:
        config = SETTINGS.with_values({"mocap.body_offset_x": offset})
        _, memory = feed(upright(30), config=config)
        for k in range(30, 300):
            stamp = PERIOD * k
            sample = PoseSample(stamp, np.array([SPEED * stamp + 2.0 * offset, 0.0]), math.pi, 0.1)
            result, memory = filter_pose(memory, sample, stamp, config)
            assert result.refused == "yaw", offset


def test_tipped_lifted_or_let_down_is_refused_for_as_long_as_it_lasts():
    for fault, reason in [((0.0, 0.1, 0.5), "tilt"), ((0.0, 0.3, 0.0), "height"), ((0.0, -0.1, 0.0), "height")]:
        _, memory = feed(upright(30))
        results, memory = feed([fault] * 1000, memory, 30)
        assert refusals(results) == {reason}, (fault, reason)
        results, _ = feed(upright(5), memory, 1030)
        assert refusals(results) == {""}, (fault, reason)


@given(height=st.floats(-3.0, 3.0), wobble=st.floats(-0.049, 0.049), tilt=st.floats(0.0, 0.26))
@FEW
def test_within_the_limits_nothing_is_refused(height, wobble, tilt):
    results, _ = feed([(0.0, height + wobble * (k % 2), tilt) for k in range(30)])
    assert refusals(results) == {""}


@given(yaw=st.floats(-math.pi, math.pi), tilt=st.floats(0.0, math.pi), around=st.floats(-math.pi, math.pi))
@FEW
def test_the_tilt_of_a_quaternion_is_the_angle_to_the_vertical(yaw, tilt, around):
    lean, upright = math.sin(0.5 * tilt), math.cos(0.5 * tilt)
    turned = lean * math.cos(around), lean * math.sin(around), upright * math.sin(yaw), upright * math.cos(yaw)
    assert tilt_of(turned) == pytest.approx(tilt, abs=1e-6)


def test_height_and_tilt_are_read_from_the_fields():
    sample = check_pose_fields(1.0, (0.5, -0.5, 0.12), (math.sin(0.2), 0.0, 0.0, math.cos(0.2)), 0.01)
    assert (sample.height, sample.tilt) == (0.12, pytest.approx(0.4))
