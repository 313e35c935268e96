"""The velocity from poses, the hits in them, and what is refused."""

import math
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Settings
from collplan_core.sensing.pose_filter import FRESH, PoseError, PoseSample, check_pose_fields, filter_pose

SETTINGS = Settings()
PERIOD = 0.01
COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") == "0"
MINUTE = 60.0 if COMPILED else 3.0


def feed(points, memory=FRESH, begin=0.0, config=SETTINGS, period=PERIOD):
    """One result for each pose, and the memory after the last."""
    results = []
    for k, point in enumerate(points):
        stamp = begin + k * period
        result, memory = filter_pose(memory, PoseSample(stamp, np.asarray(point, dtype=float), 0.0), stamp, config)
        results.append(result)
    return results, memory


def line(n, velocity, start=(0.0, 0.0)):
    return np.array(start) + PERIOD * np.outer(np.arange(n), velocity)


def driven(duration, seed, hits=(), rate=400):
    """Positions at 100 Hz of a robot driven as hard as its wheels allow, changing its mind at random.

    hits: (time, change of velocity) in order of time.
    """
    robot, rng = SETTINGS.robot, np.random.default_rng(seed)
    velocity, position, wanted, change_at = np.zeros(2), np.zeros(2), np.zeros(2), 0.0
    hits, points, step = list(hits), [], 1.0 / rate
    for k in range(int(duration * rate)):
        if k * step >= change_at:
            speed = np.hypot(*velocity)
            angle = rng.uniform(0.0, 2 * np.pi)
            reverse = speed > 0.1 and rng.uniform() < 0.5
            direction = -velocity / speed if reverse else np.array([np.cos(angle), np.sin(angle)])
            wanted, change_at = robot.max_speed * direction, k * step + rng.uniform(0.05, 0.8)
        if hits and k * step >= hits[0][0]:
            velocity = velocity + hits.pop(0)[1]
        if k % (rate // 100) == 0:
            points.append(position)
        pull = (wanted - velocity) * (1.0 - math.exp(-step / robot.velocity_lag))
        largest = robot.max_acceleration * step
        velocity = velocity + pull * min(1.0, largest / max(np.hypot(*pull), 1e-12))
        position = position + velocity * step
    return np.array(points)


def noisy(points, seed, deviation=0.002):
    return points + np.random.default_rng(seed).normal(0.0, deviation, points.shape)


# ---- velocity


@given(angle=st.floats(-3.2, 3.2), speed=st.floats(0.0, 1.2), begin=st.floats(-100.0, 1000.0))
@settings(derandomize=True, deadline=None, max_examples=20)
def test_straight_drive_is_exact(angle, speed, begin):
    velocity = speed * np.array([math.cos(angle), math.sin(angle)])
    points = line(20, velocity, (3.0, -2.0))
    results, _ = feed(points, begin=begin)
    assert [r.state is None for r in results] == [True] * 6 + [False] * 14
    for result, point in zip(results[6:], points[6:], strict=True):
        np.testing.assert_allclose(result.state.velocity, velocity, atol=1e-6)
        np.testing.assert_array_equal(result.state.position, point)
    assert not any(r.refused or r.relocated or r.impact is not None for r in results)


def test_yaw_rate_goes_through_half_a_turn():
    """As the velocity, it has no error at a constant rate, and is there with the first one."""
    for spin in [0.0, 2.5, -8.0]:
        memory = FRESH
        for k in range(100):
            sample = PoseSample(k * PERIOD, np.zeros(2), math.remainder(3.0 + spin * k * PERIOD, math.tau))
            result, memory = filter_pose(memory, sample, sample.stamp, SETTINGS)
            assert result.state is None or result.yaw_rate == pytest.approx(spin, abs=1e-9), spin
        assert result.state is not None, spin


def test_deviations_are_those_of_noise():
    """Where nothing accelerates: those of the slopes at rest, and of the pose itself what the parameters say."""
    config = SETTINGS.with_values({"mocap.yaw_noise": 0.01, "robot.max_acceleration": 0.1})
    rng, memory, found = np.random.default_rng(3), FRESH, []
    for k in range(4000 if COMPILED else 300):
        sample = PoseSample(k * PERIOD, rng.normal(0.0, 0.002, 2), rng.normal(0.0, 0.01))
        result, memory = filter_pose(memory, sample, sample.stamp, config)
        found += [] if result.state is None else [(*result.state.velocity, result.yaw_rate)]
    said = result.deviations
    assert (said.position, said.yaw) == (0.002, 0.01)
    np.testing.assert_allclose(np.std(found, axis=0), [said.velocity, said.velocity, said.yaw_rate], rtol=0.1)


def test_silence_begins_the_window_anew():
    results, memory = feed(line(20, (1.0, 0.0)))
    late = line(10, (0.0, 0.5), (0.4, 0.0))
    results, _ = feed(late, memory, begin=0.6)
    assert [r.state is None for r in results] == [True] * 6 + [False] * 4
    assert not any(r.refused for r in results)
    np.testing.assert_allclose(results[-1].state.velocity, [0.0, 0.5], atol=1e-9)


# ---- hits


def test_no_false_hit_in_hard_driving():
    for deviation in [0.0, 0.0002, 0.002]:
        config = SETTINGS.with_values({"mocap.position_noise": max(deviation, 1e-5)})
        points = driven(MINUTE, seed=11)
        results, _ = feed(noisy(points, 12, deviation), config=config)
        assert [r.impact for r in results if r.impact is not None] == [], deviation
        assert not any(r.refused for r in results), deviation


def hits_found(change, deviation, seed):
    """Delays of the first report after each hit [s], errors of the reported change, and reports that match none."""
    rng = np.random.default_rng(seed)
    hits, time = [], 1.0
    while time < 24.0:
        angle = rng.uniform(0.0, 2 * np.pi)
        hits.append((time, change * np.array([math.cos(angle), math.sin(angle)])))
        time += rng.uniform(0.8, 1.6)
    config = SETTINGS.with_values({"mocap.position_noise": deviation})
    results, _ = feed(noisy(driven(time, seed, hits), seed, deviation), config=config)
    reports = [(k * PERIOD, r.impact.change) for k, r in enumerate(results) if r.impact is not None]
    delays, errors = [], []
    for begin, true in hits:
        mine = [report for report in reports if 0.0 < report[0] - begin < 0.15]
        assert len(mine) <= 1
        delays += [mine[0][0] - begin] if mine else [math.inf]
        errors += [np.hypot(*(mine[0][1] - true))] if mine else []
    return np.array(delays), np.array(errors), len(reports) - len(errors)


@pytest.mark.skipif(not COMPILED, reason="enough hits for a share take too long without the compiler")
def test_hits_are_found_once_and_soon():
    for change, deviation, found, delay, error in (
        (0.3, 0.0002, 0.95, 0.04, 0.1),
        (0.6, 0.002, 0.95, 0.045, 0.25),
        (1.8, 0.002, 1.0, 0.03, 0.4),
    ):
        delays, errors, false = hits_found(change, deviation, seed=5)
        assert false == 0, change
        assert np.isfinite(delays).mean() >= found, change
        assert np.median(delays) <= delay, change
        assert np.median(errors) <= error, change


def test_velocity_after_a_hit_forgets_the_one_before():
    points = np.concatenate([line(30, (1.0, 0.3)), line(30, (-0.7, 0.3), (0.3, 0.09))])
    results, _ = feed(points)
    (found,) = [k for k, r in enumerate(results) if r.impact is not None]
    assert found <= 33
    np.testing.assert_allclose(results[found].impact.change, [-1.7, 0.0], atol=0.05)
    assert results[found].impact.time == pytest.approx(0.3, abs=0.001)
    np.testing.assert_allclose(results[found].impact.center, [0.3, 0.09], atol=0.001)
    for result in results[found:]:
        np.testing.assert_allclose(result.state.velocity, [-0.7, 0.3], atol=0.1)
    np.testing.assert_allclose(results[-1].state.velocity, [-0.7, 0.3], atol=1e-9)


def test_a_hit_that_is_found_in_two_parts_is_told_once():
    points = np.concatenate(
        [line(30, (1.0, 0.3)), line(6, (0.1, 0.3), (0.3, 0.09)), line(30, (-0.7, 0.3), (0.306, 0.108))]
    )
    results, _ = feed(points)
    assert len([r for r in results if r.impact is not None]) == 1
    np.testing.assert_allclose(results[42].state.velocity, [-0.7, 0.3], atol=0.05)


def test_two_walls_hit_one_soon_after_the_other_are_told_both():
    points = np.concatenate(
        [line(30, (1.0, 1.0)), line(6, (-0.7, 1.0), (0.3, 0.3)), line(30, (-0.7, -0.7), (0.258, 0.36))]
    )
    results, _ = feed(points)
    x, y = (r.impact.change for r in results if r.impact is not None)
    np.testing.assert_allclose([x, y], [[-1.7, 0.0], [0.0, -1.7]], atol=0.1)


def test_detection_can_be_switched_off():
    points = np.concatenate([line(30, (1.0, 0.0)), line(30, (-0.7, 0.0), (0.3, 0.0))])
    results, _ = feed(points, config=SETTINGS.with_values({"mocap.detect_impacts": False}))
    assert all(r.impact is None for r in results)


# ---- refusals


@given(leap=st.floats(0.35, 5.0), speed=st.floats(0.0, 0.2))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_a_leap_does_not_become_motion_by_lasting(leap, speed):
    """By 0.5 m is in reach 0.31 s later."""
    _, memory = feed(line(20, (0.0, 0.0)))
    results, _ = feed(line(70, (0.0, speed), (leap, 0.0)), memory, begin=0.2)
    assert {r.refused for r in results[:50]} == {"leap"}
    assert [k for k, r in enumerate(results) if r.carried and r.relocated] == [50]
    np.testing.assert_allclose(results[50].state.velocity, [0.0, speed], atol=1e-9)
    assert not any(r.refused or r.impact for r in results[50:])


@given(distance=st.floats(0.3, 2.0), lasts=st.integers(1, 14))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_a_robot_that_goes_on_after_a_shorter_leap_is_believed_at_once(distance, lasts):
    _, memory = feed(line(20, (1.0, 0.0)))
    aside = line(lasts, (1.0, 0.0), (0.2, distance))
    back = line(30, (1.0, 0.0), (0.2 + PERIOD * lasts, 0.0))
    results, _ = feed(np.concatenate([aside, back]), memory, begin=0.2)
    assert results[0].refused == "leap"
    assert not any(r.refused for r in results[lasts:])


@given(periods=st.integers(2, 200), speed=st.floats(0.0, 1.2))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_a_clock_that_is_set_back_while_the_robot_drives_and_brakes_carries_nobody(periods, speed):
    """Once its stamps are later than those of before, the robot is where it drove meanwhile: that looks like a leap."""
    back = PERIOD * (periods + 0.5)
    times = PERIOD * np.arange(120)
    braking = np.minimum(times, speed / 1.5)
    points = np.column_stack([speed * braking - 0.75 * braking**2, 0.0 * times])
    _, memory = feed(line(20, (speed, 0.0), (-0.2 * speed, 0.0)), begin=5.0)
    results = []
    for k, point in enumerate(points):
        sample = PoseSample(5.2 + k * PERIOD - back, point, 0.0)
        result, memory = filter_pose(memory, sample, 5.2 + k * PERIOD, SETTINGS)
        results.append(result)
    assert results[0].refused == "stamp"
    assert not any(r.carried for r in results)
    assert results[-1].state is not None


def test_poses_that_do_not_agree_are_no_relocation():
    _, memory = feed(line(20, (1.0, 0.0)))
    wild = np.random.default_rng(2).uniform(-5.0, 5.0, (150, 2)) + 10.0
    results, _ = feed(wild, memory, begin=0.2)
    assert all(r.refused for r in results)


def test_interrupted_suspects_begin_anew():
    """0.3 s elsewhere, silence, 0.3 s elsewhere: never 0.5 s in agreement."""
    _, memory = feed(line(20, (0.0, 0.0)))
    for begin in (0.2, 0.8):
        results, memory = feed(line(30, (0.0, 0.0), (3.0, 1.0)), memory, begin=begin)
        assert {r.refused for r in results} == {"leap"}


@given(gap=st.floats(0.011, 3.0), share=st.floats(0.0, 0.99))
@settings(derandomize=True, deadline=None, max_examples=30)
def test_what_the_robot_can_reach_is_no_leap(gap, share):
    _, memory = feed(line(20, (0.0, 0.0)))
    reach = SETTINGS.robot.max_speed * gap
    results, _ = feed([(share * reach, 0.0)], memory, begin=0.19 + gap)
    assert results[0].refused == ""
    results, _ = feed([(1.2 * reach + 0.051 + share, 0.0)], memory, begin=0.19 + gap)
    assert results[0].refused == "leap"


def test_stamp_far_ahead_buys_no_leap():
    _, memory = feed(line(20, (0.0, 0.0)))
    sample = PoseSample(1000.0, np.array([2.0, 0.0]), 0.0)
    assert filter_pose(memory, sample, 0.2, SETTINGS)[0].refused == "leap"


def test_stamp_that_does_not_rise_is_refused():
    for stamp in [0.19, 0.1, -7.0]:
        _, memory = feed(line(20, (0.0, 0.0)))
        results, memory = feed([(0.0, 0.0)], memory, begin=stamp)
        assert results[0].refused == "stamp", stamp
        results, _ = feed([(0.0, 0.0)], memory, begin=0.2)
        assert results[0].refused == "", stamp


def test_not_finite_is_refused_without_a_trace():
    _, rolling = feed(line(20, (0.0, 0.0)))
    for value in (math.nan, math.inf, -math.inf):
        for field in range(6):
            stamp, x, y, *others = [
                value if k == field else each for k, each in enumerate((0.2, 0.0, 0.0, 0.0, 0.0, 0.0))
            ]
            for memory in (rolling, FRESH):
                result, after = filter_pose(memory, PoseSample(stamp, np.array([x, y]), *others), 0.2, SETTINGS)
                assert (result.state, result.refused, after) == (None, "not_finite", memory), (value, field)


GOOD = (1.0, (0.5, -0.5, 0.1), (0.0, 0.0, math.sin(0.4), math.cos(0.4)))


def test_fields_of_a_pose_and_those_that_are_none():
    sample = check_pose_fields(*GOOD, tolerance=0.01)
    assert (sample.stamp, sample.position.tolist(), sample.yaw) == (1.0, [0.5, -0.5], pytest.approx(0.8))
    assert check_pose_fields(0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), 0.01).yaw == 0.0
    for reason, stamp, position, quaternion in [
        ("not_finite", math.nan, GOOD[1], GOOD[2]),
        ("not_finite", 1.0, (math.inf, 0.0, 0.0), GOOD[2]),
        ("not_finite", 1.0, (0.0, 0.0, math.nan), GOOD[2]),
        ("not_finite", 1.0, GOOD[1], (0.0, 0.0, math.nan, 1.0)),
        ("zeros", 1.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
        ("quaternion", 1.0, GOOD[1], (0.0, 0.0, 0.0, 0.0)),
        ("quaternion", 1.0, GOOD[1], (0.0, 0.0, 0.0, 1.02)),
        ("quaternion", 1.0, GOOD[1], (1.0, 1.0, 1.0, 1.0)),
    ]:
        with pytest.raises(PoseError) as error:
            check_pose_fields(stamp, position, quaternion, 0.01)
        assert error.value.reason == reason, (reason, stamp, position, quaternion)


def test_any_rate():
    """Straight on at any rate of the motion capture: the velocity is right, and nothing is a hit."""
    for period in [0.0025, 0.008, 0.03, 0.05, 0.1]:
        points = np.outer(np.arange(40) * period, (0.9, -0.3))
        results, _ = feed(points, period=period)
        np.testing.assert_allclose(results[-1].state.velocity, [0.9, -0.3], atol=1e-6)
        assert all(r.impact is None for r in results), period
