"""What becomes of poses: velocity, hits, what a robot on a floor cannot do and is refused, and the pose at a stamp."""

import math
import os

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.ages import why_clock_is_wrong
from collplan_core.parameters import Settings
from collplan_core.poses.mocap_body import even_stamp
from collplan_core.poses.pose_filter import FRESH, PoseError, PoseSample, check_pose_fields, filter_pose, speed_limit
from collplan_core.poses.pose_filter import SPEED as SPEED_REFUSED
from collplan_core.poses.pose_history import PoseHistory
from collplan_core.poses.six_degrees import tilt_of
from collplan_core.state import State

SETTINGS = Settings()
PERIOD = 0.01
COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") == "0"
MINUTE = 60.0 if COMPILED else 3.0


def fed(samples, memory=FRESH, config=SETTINGS):
    results = []
    for sample in samples:
        result, memory = filter_pose(memory, sample, sample.stamp, config)
        results.append(result)
    return results, memory


def feed(points, memory=FRESH, begin=0.0, config=SETTINGS, period=PERIOD):
    points = np.asarray(points, dtype=float)
    return fed((PoseSample(begin + k * period, point, 0.0) for k, point in enumerate(points)), memory, config)


def line(n, velocity, start=(0.0, 0.0)):
    return np.array(start) + PERIOD * np.outer(np.arange(n), velocity)


RESTITUTION = 0.7


def driven(duration, seed, change=0.0, rate=400):
    """Positions at 100 Hz of a robot driven as hard as its wheels allow, and its hits, one a second."""
    robot, rng = SETTINGS.robot, np.random.default_rng(seed)
    velocity, position, wanted, change_at = np.zeros(2), np.zeros(2), np.zeros(2), 0.0
    hits, points, step = [], [], 1.0 / rate
    for k in range(int(duration * rate)):
        if k * step >= change_at:
            speed = np.hypot(*velocity)
            angle = rng.uniform(0.0, 2 * np.pi)
            reverse = speed > 0.1 and rng.uniform() < 0.5
            direction = -velocity / speed if reverse else np.array([np.cos(angle), np.sin(angle)])
            wanted, change_at = robot.max_speed * direction, k * step + rng.uniform(0.05, 0.8)
        approach, speed = change / (1.0 + RESTITUTION), np.hypot(*velocity)
        if change and speed >= approach and k * step >= (hits[-1] if hits else 0.0) + 1.0:
            slant = rng.choice([-1, 1]) * math.acos(approach / speed)
            along = math.atan2(velocity[1], velocity[0]) + slant
            velocity = velocity - change * np.array([math.cos(along), math.sin(along)])
            hits.append(k * step)
        if k % (rate // 100) == 0:
            points.append(position)
        pull = (wanted - velocity) * (1.0 - math.exp(-step / robot.velocity_lag))
        largest = robot.max_acceleration * step
        velocity = velocity + pull * min(1.0, largest / max(np.hypot(*pull), 1e-12))
        position = position + velocity * step
    return np.array(points), hits


def noisy(points, seed, deviation=0.002):
    return points + np.random.default_rng(seed).normal(0.0, deviation, points.shape)


@given(angle=st.floats(-3.2, 3.2), speed=st.floats(0.0, 1.2), begin=st.floats(-100.0, 1000.0))
def test_straight_drive_is_exact_at_any_rate(angle, speed, begin):
    velocity = speed * np.array([math.cos(angle), math.sin(angle)])
    for period, first in ((0.005, None), (PERIOD, 6), (0.1, None)):
        points = np.array([3.0, -2.0]) + period * np.outer(np.arange(40), velocity)
        results, _ = feed(points, begin=begin, period=period)
        assert first is None or [r.state is None for r in results[: first + 1]] == [True] * first + [False]
        for result, point in zip(results[30:], points[30:], strict=True):
            np.testing.assert_allclose(result.state.velocity, velocity, atol=1e-6)
            np.testing.assert_array_equal(result.state.position, point)
        assert not any(r.refused or r.relocated or r.impact is not None for r in results)


def test_yaw_rate_goes_through_half_a_turn():
    for spin in [0.0, 2.5, -8.0]:
        yaws = [math.remainder(3.0 + spin * k * PERIOD, math.tau) for k in range(100)]
        results, _ = fed(PoseSample(k * PERIOD, np.zeros(2), yaw) for k, yaw in enumerate(yaws))
        assert results[-1].state is not None, spin
        assert all(r.state is None or r.yaw_rate == pytest.approx(spin, abs=1e-9) for r in results), spin


def test_deviations_are_those_of_noise():
    config = SETTINGS.with_values({"mocap.yaw_noise": 0.01, "robot.max_acceleration": 0.1})
    rng, n = np.random.default_rng(3), 4000 if COMPILED else 300
    poses = (PoseSample(k * PERIOD, rng.normal(0.0, 0.002, 2), rng.normal(0.0, 0.01)) for k in range(n))
    results, _ = fed(poses, config=config)
    found = [(*result.state.velocity, result.yaw_rate) for result in results if result.state is not None]
    said = results[-1].deviations
    assert (said.position, said.yaw) == (0.002, 0.01)
    np.testing.assert_allclose(np.std(found, axis=0), [said.velocity, said.velocity, said.yaw_rate], rtol=0.1)


def test_no_false_hit_in_hard_driving():
    for deviation in [0.0, 0.0002, 0.002]:
        config = SETTINGS.with_values({"mocap.position_noise": max(deviation, 1e-5)})
        points, _ = driven(MINUTE, seed=11)
        results, _ = feed(noisy(points, 12, deviation), config=config)
        assert [r.impact for r in results if r.impact is not None] == [], deviation
        assert not any(r.refused for r in results), deviation


def test_what_a_robot_has_shown_is_no_hit_and_its_hits_are():
    time = 0.02 * np.arange(1000)
    speed = np.interp(time % 4.0, (0.0, 0.3, 1.5, 1.8, 4.0), (0.0, 1.2, 1.2, 0.0, 0.0))
    along = 0.02 * np.cumsum(np.where(time % 8.0 < 4.0, speed, -speed))
    points = noisy(np.column_stack([along, 0.0 * along]), 1, 0.0002)
    config = SETTINGS.with_values({"mocap.position_noise": 0.0002})
    results, memory = feed(points, config=config, period=0.02)
    assert not [result.impact for result in results[200:] if result.impact]
    assert 3.0 < memory.shown.most < 4.3
    back = points[-1] + np.concatenate([0.02 * line(30, (50.0, 0.0)), [[0.3, 0.0]] - 0.02 * line(30, (40.0, 0.0))])
    results, _ = feed(back, memory, begin=20.0, config=config, period=0.02)
    assert len([result.impact for result in results if result.impact]) == 1


def hits_found(change, deviation, seed):
    points, hits = driven(40.0, seed, change)
    config = SETTINGS.with_values({"mocap.position_noise": deviation})
    results, _ = feed(noisy(points, seed, deviation), config=config)
    reports = [k * PERIOD for k, r in enumerate(results) if r.impact is not None]
    mine = [[report - begin for report in reports if 0.0 < report - begin < 0.15] for begin in hits]
    return np.array([delays[0] if delays else math.inf for delays in mine]), len(reports) - sum(map(bool, mine))


@pytest.mark.skipif(not COMPILED, reason="enough hits for a share take too long without the compiler")
def test_hits_are_found_once_and_soon():
    for change, deviation, delay in ((0.3, 0.0002, 0.04), (0.6, 0.002, 0.045), (1.8, 0.002, 0.03)):
        delays, false = hits_found(change, deviation, seed=7)
        assert false == 0, change
        assert np.isfinite(delays).mean() >= 0.95, change
        assert np.median(delays) <= delay, change


def test_velocity_after_a_hit_forgets_the_one_before():
    points = np.concatenate([line(30, (1.0, 0.3)), line(30, (-0.7, 0.3), (0.3, 0.09))])
    results, _ = feed(points)
    (found,) = [k for k, r in enumerate(results) if r.impact is not None]
    assert found == 32
    np.testing.assert_allclose(results[found].impact.change, [-1.7, 0.0], atol=0.05)
    assert results[found].impact.time == pytest.approx(0.3, abs=0.001)
    np.testing.assert_allclose(results[found].impact.point, [0.3 + Settings().robot.radius, 0.09], atol=0.005)
    np.testing.assert_allclose(results[found].impact.velocity_before, [1.0, 0.3], atol=0.05)
    for result in results[found:]:
        np.testing.assert_allclose(result.state.velocity, [-0.7, 0.3], atol=0.1)
    np.testing.assert_allclose(results[-1].state.velocity, [-0.7, 0.3], atol=1e-9)


def test_a_hit_that_is_found_in_two_parts_is_told_once_and_two_walls_soon_after_each_other_both():
    for parts, changes in (
        ([((1.0, 0.3), (0.0, 0.0)), ((0.1, 0.3), (0.3, 0.09)), ((-0.7, 0.3), (0.306, 0.108))], [None]),
        ([((1.0, 1.0), (0.0, 0.0)), ((-0.7, 1.0), (0.3, 0.3)), ((-0.7, -0.7), (0.258, 0.36))], [(-1.7, 0), (0, -1.7)]),
    ):
        ways = [line(n, *part) for n, part in zip((30, 6, 30), parts, strict=True)]
        results, _ = feed(np.concatenate(ways))
        for expected, found in zip(changes, (r.impact.change for r in results if r.impact is not None), strict=True):
            assert expected is None or found == pytest.approx(expected, abs=0.1)
        np.testing.assert_allclose(results[42].state.velocity, parts[-1][0], atol=0.05)


@given(leap=st.floats(0.35, 5.0), speed=st.floats(0.0, 0.2))
def test_a_leap_does_not_become_motion_by_lasting(leap, speed):
    """By 0.5 m is in reach 0.31 s later."""
    _, memory = feed(line(20, (0.0, 0.0)))
    results, _ = feed(line(70, (0.0, speed), (leap, 0.0)), memory, begin=0.2)
    assert {r.refused for r in results[:50]} == {"leap"}
    assert [k for k, r in enumerate(results) if r.kidnapped and r.relocated] == [50]
    np.testing.assert_allclose(results[50].state.velocity, [0.0, speed], atol=1e-9)
    assert not any(r.refused or r.impact for r in results[50:])


@given(distance=st.floats(0.3, 2.0), lasts=st.integers(1, 14))
def test_a_robot_that_goes_on_after_a_shorter_leap_is_believed_at_once(distance, lasts):
    _, memory = feed(line(20, (1.0, 0.0)))
    aside = line(lasts, (1.0, 0.0), (0.2, distance))
    back = line(30, (1.0, 0.0), (0.2 + PERIOD * lasts, 0.0))
    results, _ = feed(np.concatenate([aside, back]), memory, begin=0.2)
    assert results[0].refused == "leap"
    assert not any(r.refused for r in results[lasts:])


@given(periods=st.integers(2, 200), speed=st.floats(0.0, 1.2))
def test_a_clock_that_is_set_back_while_the_robot_drives_and_brakes_carries_nobody(periods, speed):
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
    assert not any(r.kidnapped for r in results)
    assert results[-1].state is not None


def test_poses_that_do_not_agree_or_are_interrupted_are_no_relocation():
    _, memory = feed(line(20, (1.0, 0.0)))
    wild = np.random.default_rng(2).uniform(-5.0, 5.0, (150, 2)) + 10.0
    assert all(r.refused for r in feed(wild, memory, begin=0.2)[0])
    _, memory = feed(line(20, (0.0, 0.0)))
    for begin in (0.2, 0.8):
        results, memory = feed(line(30, (0.0, 0.0), (3.0, 1.0)), memory, begin=begin)
        assert {r.refused for r in results} == {"leap"}


@given(gap=st.floats(0.011, 3.0), share=st.floats(0.0, 0.99))
def test_what_the_robot_can_reach_is_no_leap(gap, share):
    _, memory = feed(line(20, (0.0, 0.0)))
    reach = SETTINGS.robot.max_speed * gap
    results, _ = feed([(share * reach, 0.0)], memory, begin=0.19 + gap)
    assert results[0].refused == ""
    results, _ = feed([(1.2 * reach + 0.051 + share, 0.0)], memory, begin=0.19 + gap)
    assert results[0].refused == "leap"
    ahead = PoseSample(1000.0, np.array([2.0, 0.0]), 0.0)  # by its stamp alone
    assert filter_pose(memory, ahead, 0.2, SETTINGS)[0].refused == "leap"


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
        ("not_finite", 1.0, GOOD[1], (0.0, 0.0, math.nan, 1.0)),
        ("quaternion", 1.0, GOOD[1], (0.0, 0.0, 0.0, 1.02)),
    ]:
        with pytest.raises(PoseError) as error:
            check_pose_fields(stamp, position, quaternion, 0.01)
        assert error.value.reason == reason, (reason, stamp, position, quaternion)


SPEED = 0.6


def feed_tilted(poses, memory=FRESH, begin=0, config=SETTINGS):
    """A result for each (yaw, height, tilt), 10 ms apart on the way along x, and the memory after the last."""
    samples = (
        PoseSample(PERIOD * k, np.array([SPEED * PERIOD * k, 0.0]), math.remainder(yaw, math.tau), height, tilt)
        for k, (yaw, height, tilt) in enumerate(poses, begin)
    )
    return fed(samples, memory, config)


def upright(n, yaw=0.0, height=0.1):
    return [(yaw, height, 0.0)] * n


def refusals(results):
    return {result.refused for result in results}


def test_what_no_robot_on_a_floor_does_is_refused_for_as_long_as_it_lasts():
    turns = [(2.8 + angle, 0.1, 0.0, "yaw") for angle in (math.pi / 2, -math.pi / 2, math.pi, -2.0)]
    for *fault, reason in (*turns, (2.8, 0.1, 0.5, "tilt"), (2.8, 0.3, 0.0, "height"), (2.8, -0.1, 0.0, "height")):
        _, memory = feed_tilted(upright(30, yaw=2.8))
        results, memory = feed_tilted([fault] * 300, memory, 30)
        assert refusals(results[0 if reason == "yaw" else 6 :]) == {reason}, fault
        results, _ = feed_tilted(upright(5, yaw=2.8), memory, 330)
        assert refusals(results) == {""}, fault


@given(angle=st.floats(0.3, 1.5))
def test_a_smaller_leap_is_refused_until_the_robot_can_have_turned_so_far(angle):
    _, memory = feed_tilted(upright(30))
    results, _ = feed_tilted(upright(40, yaw=angle), memory, 30)
    taken = [not result.refused for result in results]
    first = taken.index(True)
    assert first >= 1
    assert PERIOD * first <= SETTINGS.limits.pose_age
    assert all(taken[first:])


def test_turned_while_it_was_off_the_floor_or_unseen_is_a_relocation():
    for fault, reason in [(None, ""), ((0.0, 0.1, 0.5), "tilt"), ((0.0, 0.3, 0.0), "height")]:
        _, memory = feed_tilted(upright(30))
        if reason:
            results, memory = feed_tilted([fault] * 61, memory, 30)
            assert refusals(results[6:]) == {reason}, (fault, reason)
        results, _ = feed_tilted(upright(70, yaw=math.pi), memory, 91)
        assert refusals(results[:50]) == {"yaw"}, (fault, reason)
        assert [k for k, result in enumerate(results) if result.relocated] == [50], (fault, reason)
        assert results[50].kidnapped, (fault, reason)
        assert refusals(results[50:]) == {""}, (fault, reason)


def test_single_tipped_poses_are_left_out_and_stop_nobody():
    poses = [(0.0, 0.1, 0.5 if k % 20 in (13, 14, 15, 16) else 0.0) for k in range(200)]
    results, _ = feed_tilted(poses)
    assert refusals(results) == {""}
    assert [k for k, result in enumerate(results[40:], 40) if result.state is None] == [
        k for k in range(40, 200) if poses[k][2]
    ]


@given(tilt=st.floats(0.0, math.radians(5.0)), uphill=st.floats(-math.pi, math.pi))
def test_a_floor_tilted_against_the_axes_is_one_and_a_lift_on_it_is_found(tilt, uphill):
    memory, slope = FRESH, math.tan(tilt)
    for k in range(800):
        along = SPEED * PERIOD * k
        x, y = (along, 0.0) if along < 1.0 else (1.0, along - 1.0)
        height = 0.1 + slope * (x * math.cos(uphill) + y * math.sin(uphill))
        result, memory = filter_pose(
            memory, PoseSample(PERIOD * k, np.array([x, y]), 0.0, height), PERIOD * k, SETTINGS
        )
        assert not result.refused, (x, y)
    lifted = PoseSample(8.0, np.array([x, y]), 0.0, height + 0.08)
    assert filter_pose(memory, lifted, 8.0, SETTINGS)[0].refused == "height"


@given(yaw=st.floats(-math.pi, math.pi), tilt=st.floats(0.0, math.pi), around=st.floats(-math.pi, math.pi))
def test_the_tilt_of_a_quaternion_is_the_angle_to_the_vertical(yaw, tilt, around):
    lean, upright = math.sin(0.5 * tilt), math.cos(0.5 * tilt)
    turned = lean * math.cos(around), lean * math.sin(around), upright * math.sin(yaw), upright * math.cos(yaw)
    assert tilt_of(turned) == pytest.approx(tilt, abs=1e-6)
    sample = check_pose_fields(1.0, (0.5, -0.5, 0.12), turned, 0.01)
    assert (sample.height, sample.tilt) == (0.12, pytest.approx(tilt, abs=1e-6))


def state(stamp, x=0.0, yaw=0.0):
    return State(stamp, np.array([x, -x]), np.array([1.0, x]), yaw)


def history(*states, span=0.5):
    kept = PoseHistory(span)
    for each in states:
        kept.add(each)
    return kept


def test_there_is_none_before_the_first_after_the_last_nor_once_cleared():
    assert PoseHistory(0.5).at(0.0) is None
    kept = history(state(1.0), state(1.1))
    assert [kept.at(stamp) is None for stamp in (0.999, 1.0, 1.1, 1.101)] == [True, False, False, True]
    kept.clear()
    assert kept.at(1.0) is None
    kept = history(*(state(0.1 * k) for k in range(20)), span=0.5)
    assert [kept.at(stamp) is None for stamp in (1.39, 1.41)] == [True, False]


@given(yaw=st.floats(-math.pi, math.pi), turn=st.floats(-3.0, 3.0), share=st.floats(0.0, 1.0))
def test_between_two_it_is_linear_and_yaw_goes_the_shortest_way(yaw, turn, share):
    ends = state(1.0, 2.0, yaw), state(1.5, -3.0, math.remainder(yaw + turn, math.tau))
    at, x = history(*ends).at(1.0 + 0.5 * share), 2.0 - 5.0 * share
    assert math.remainder(at.yaw - (yaw + share * turn), math.tau) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose([at.stamp, *at.position, *at.velocity], [1.0 + 0.5 * share, x, -x, 1.0, x], atol=1e-12)


def test_clock_set_back_begins_anew():
    for stamp in [1.9, 1.0, -5.0]:
        kept = history(state(1.0), state(1.9), state(stamp))
        assert kept.at(stamp) is not None, stamp
        assert kept.at(1.45) is None, stamp


def bursts(n):
    """Times at which each of 3,000 poses, 100 a second, is received where n come at once."""
    k = np.arange(3000)
    return PERIOD * (k - k % n + n - 1) + 1e-4 * (k % n)


def stalls(duration):
    times = PERIOD * np.arange(3000)
    since = times % 0.5
    waits = np.where(since < duration, times - since + duration, times)
    return np.maximum.accumulate(waits) + 1e-6 * np.arange(3000)


def uneven():
    rng = np.random.default_rng(4)
    batches = rng.choice([1, 2, 3, 4, 5, 9], 3000)
    ends = np.repeat(np.cumsum(batches), batches)[:3000]
    return PERIOD * ends + 3e-6 * np.arange(3000)


RECEIPTS = {
    **{f"bursts of {n}": bursts(n) for n in (2, 4, 5, 8, 20)},
    **{f"stalls of {t} s": stalls(t) for t in (0.06, 0.12, 0.2)},
    "uneven": uneven(),
}


def on_a_circle(receipts, rate=0.0):
    """Speeds, impacts and refusals of a robot at 1 m/s whose poses are stamped at receipt, or evenly."""
    memory, stamp, speeds, impacts, refused = FRESH, math.nan, [], 0, set()
    noise = np.random.default_rng(8).normal(0.0, 0.0005, (len(receipts), 2))
    for k, received in enumerate(receipts.tolist()):
        point = np.array([math.cos(PERIOD * k), math.sin(PERIOD * k)]) + noise[k]
        stamp = even_stamp(stamp, received, 1.0 / rate) if rate else received
        result, memory = filter_pose(memory, PoseSample(stamp, point, 0.0), received, SETTINGS)
        impacts += result.impact is not None
        refused.add(result.refused)
        if result.state is not None:
            speeds.append(float(np.hypot(*result.state.velocity)))
    return np.array(speeds), impacts, refused


@pytest.mark.parametrize("name", RECEIPTS)
def test_no_stamps_give_a_speed_or_an_impact_that_the_robot_cannot_have_and_even_ones_give_its_own(name):
    receipts = RECEIPTS[name]
    speeds, impacts, refused = on_a_circle(receipts)
    assert (impacts, refused) == (0, {""})
    assert not len(speeds) or speeds.max() <= speed_limit(SETTINGS)
    silent = np.diff(receipts).max() > SETTINGS.limits.pose_age
    assert silent or len(speeds) == pytest.approx(len(receipts), rel=0.01)
    if name in ("bursts of 20", "stalls of 0.2 s"):
        return
    speeds, impacts, _ = on_a_circle(receipts, rate=100.0)
    assert impacts == 0
    assert len(speeds) > 0.9 * len(receipts)
    assert np.median(speeds) == pytest.approx(1.0, abs=0.05)
    assert np.percentile(np.abs(speeds - 1.0), 95) < 0.35


@pytest.mark.parametrize(("n", "rate"), [(2, 0.0), (4, 0.0), (5, 100.0), (8, 100.0)])
def test_a_hit_is_found_in_bursts_too_once_and_where_it_was(n, rate):
    """From 50 ms on with even stamps alone."""
    points = np.concatenate([line(1500, (0.6, 0.1)), line(1500, (-0.4, 0.1), (9.0, 1.5))])
    memory, stamp, impacts = FRESH, math.nan, []
    for received, point in zip(bursts(n).tolist(), noisy(points, 5, 0.0005), strict=True):
        stamp = even_stamp(stamp, received, 1.0 / rate) if rate else received
        result, memory = filter_pose(memory, PoseSample(stamp, point, 0.0), received, SETTINGS)
        impacts += [] if result.impact is None else [result.impact]
    (impact,) = impacts
    np.testing.assert_allclose(impact.change, (-1.0, 0.0), atol=0.2)
    assert impact.time == pytest.approx(15.0, abs=PERIOD * n)


def test_a_value_sent_again_before_the_next_is_measured_is_no_stop():
    points = [(0.3 * 0.05 * min(3 * (k // 3), 200), 0.0) for k in range(300)]
    results, _ = feed(points, config=SETTINGS.with_values({"limits.pose_age": 0.3}), period=0.05)
    assert not any(result.impact or result.refused for result in results)
    speeds = [np.hypot(*result.state.velocity) for result in results[20:200] if result.state is not None]
    np.testing.assert_allclose(speeds, 0.3, atol=1e-6)
    assert all(np.hypot(*result.state.velocity) < 1e-6 for result in results[230:])


NOT_WALLS = {
    "clock twice as fast": lambda t: np.column_stack([np.where(t < 1.0, 0.4 * t, 0.4 + 0.2 * (t - 1.0)), 0.0 * t]),
    "origin set anew by 4 cm": lambda t: np.column_stack([0.3 * t + 0.04 * (t > 1.0), 0.04 * (t > 1.0)]),
    "another body for a moment": lambda t: np.column_stack([0.3 * t, 0.045 * ((t > 1.0) & (t < 1.3))]),
    "noise of 8 mm": lambda t: np.random.default_rng(2).normal(0.0, 0.008, (len(t), 2)),
    "steps of 5 mm": lambda t: np.round(np.column_stack([0.4 * t, 0.1 * t]) / 0.005) * 0.005,
    "an outlier a second": lambda t: np.column_stack([0.3 * t, 0.04 * (np.arange(len(t)) % 100 == 50)]),
}


@pytest.mark.parametrize("name", NOT_WALLS)
def test_what_something_else_explains_is_no_impact(name):
    times = PERIOD * np.arange(400)
    results, _ = feed(NOT_WALLS[name](times))
    assert not [result.impact for result in results if result.impact is not None]


def test_a_speed_that_cannot_be_is_refused_and_trusted_again_after_a_time():
    _, memory = feed(line(20, (0.5, 0.0)))
    fast = np.array([[0.1 + 0.004 * k, 0.0] for k in range(100)])
    results, memory = feed(fast, memory, begin=0.2, period=0.0008)
    assert results[-1].refused == SPEED_REFUSED
    assert all(r.state is None or np.hypot(*r.state.velocity) <= speed_limit(SETTINGS) for r in results)
    results, _ = feed(line(100, (0.5, 0.0), (0.5, 0.0)), memory, begin=0.34)
    believed = [r.state is not None for r in results]
    assert 40 <= believed.index(True) <= 60
    assert all(believed[60:])


WHY = (
    (PoseSample(0.0, np.zeros(2), 0.0), ("0.000 s is not later than the last, 0.190 s", "receiver stamp")),
    (PoseSample(0.2, np.array([10.19, 0.0]), 0.0), ("10.00 m within 0.010 s", "max_speed 1.2", "mocap.units (m)")),
    (PoseSample(0.3, np.array([0.19, 0.0]), 0.0, tilt=1.57), ("tilted by 1.57 rad", "mocap.max_tilt", "mocap.axes")),
    (PoseSample(0.2, np.array([0.19, 0.0]), 0.0, height=0.4), ("0.400 m off", "mocap.max_lift", "mocap.axes")),
    (PoseSample(0.2, np.array([0.19, 0.0]), 3.0), ("turned by 172 degrees within 0.010 s", "mocap.max_spin 9")),
)


def test_a_refusal_names_value_expectation_and_parameter():
    _, memory = feed(line(20, (1.0, 0.0)))
    for sample, words in WHY:
        result, _ = filter_pose(memory, sample, sample.stamp, SETTINGS)
        assert all(word in result.why for word in words), result.why


def test_a_speed_that_cannot_be_asks_for_the_stamps():
    _, memory = feed(line(20, (1.0, 0.0)))
    for k in range(1, 12):
        sample = PoseSample(0.19 + 1e-4 * k, np.array([0.19 + PERIOD * k, 0.0]), 0.0)
        result, memory = filter_pose(memory, sample, sample.stamp, SETTINGS)
        if result.refused:
            break
    assert all(word in result.why for word in ("poses within", "expected at most 1.57", "mocap.rate")), result.why


def test_stamps_that_do_not_run_as_time_does_are_named():
    for stamps, elapsed in ((0.001, 1.0), (0.4, 1.0), (1.0, 2.0), (2.5, 1.0)):
        assert f"{stamps:g} s of stamps in {elapsed:.2f} s" in why_clock_is_wrong(stamps, elapsed)
        assert why_clock_is_wrong(elapsed, elapsed) == why_clock_is_wrong(0.7 * elapsed, elapsed) == ""
    assert "header.stamp" in why_clock_is_wrong(1000.0, 1.0)
