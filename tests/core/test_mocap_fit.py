"""Motion capture: what it measures becomes the robot's pose; the body's place on the robot from motions and turns."""

import cmath
import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from collplan_core.calibration.mocap_offset import body_offset
from collplan_core.calibration.stream_quality import stream_quality
from collplan_core.calibration.stroke_fit import AxesFit, Stroke, fit_axes
from collplan_core.calibration.turn_fit import FittedTurn, TurnFit, fit_turns
from collplan_core.parameters import Mocap
from collplan_core.parameters.spec import ParameterError
from collplan_core.poses.mocap_body import MeasuredPose, robot_pose, with_offset
from collplan_core.poses.pose_filter import PoseError, PoseSample

short = st.floats(-0.2, 0.2)


@given(short, short, st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_the_offset_puts_the_body_where_it_is_seen(lever_x, lever_y, turn, heading):
    offset = body_offset(AxesFit(turn, 0.01, 1.0, False), TurnFit(np.array([lever_x, lever_y]), 1e-3))
    body = with_offset(PoseSample(0.0, np.zeros(2), heading), offset.x, offset.y, offset.yaw)
    lever = complex(lever_x, lever_y) * np.exp(1j * body.yaw)
    np.testing.assert_allclose(body.position, [lever.real, lever.imag], atol=1e-12)
    assert abs(math.remainder(body.yaw + turn - heading, math.tau)) < 1e-12
    # an uncertain heading makes the position on the robot uncertain
    offset = body_offset(AxesFit(0.0, 0.01, 1.0, False), TurnFit(np.array([0.3, 0.4]), 0.012))
    assert (offset.position_uncertainty, offset.yaw_uncertainty) == pytest.approx((0.013, 0.01))


def test_quality_of_a_stream():
    random = np.random.default_rng(3)
    stamps = 0.01 * np.arange(400)
    received = stamps + 7.0
    received[200:] += 0.05
    quality = stream_quality(stamps, received, random.normal(0.0, (0.001, 0.002), (400, 2)))
    assert quality.rate == pytest.approx(100.0)
    assert quality.longest_gap == pytest.approx(0.06)
    assert quality.jitter < 0.001
    assert quality.noise == pytest.approx(0.002, rel=0.1)


angles = st.floats(-3.1, 3.1)
slow = st.complex_numbers(max_magnitude=0.05, allow_nan=False)
WAYS = 0.1 * np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])
ORIGIN = np.zeros(2)


def strokes(offset=(0.0, 0.0, 0.0), *, scale=1.0, bias=0.0, drift=0.0, yaws=(0.0,), mirror=False, noise=None, veer=0.0):
    """Four strokes at each heading, seen from a body at `offset`: bias of the robot, drift of the room [m/s]."""
    made = []
    for yaw in yaws:
        for way in WAYS:
            velocity = complex(*(way * (1, -1) if mirror else way).tolist())
            duration = 1.0 + 0.3 * len(made) % 1.0
            # as by the chord of an arc where it veers
            moved = (scale * velocity + bias) * np.exp(1j * (yaw + 0.5 * veer)) * duration + drift * duration
            moved += 0.0 if noise is None else noise() * math.sqrt(duration)
            ends = [(0.0, yaw), (moved, yaw + veer)]
            seen = [with_offset(PoseSample(0.0, np.array([z.real, z.imag]), a), *offset) for z, a in ends]
            made.append(Stroke(way, duration, *seen))
    return made


@given(st.tuples(short, short, angles), st.floats(0.5, 2.0), slow, slow, angles, st.floats(-0.2, 0.2))
def test_turn_scale_and_biases_are_found(offset, scale, bias, drift, yaw, veer):
    driven = strokes(offset, scale=scale, bias=bias, drift=drift, yaws=(yaw, yaw + 2.0, yaw + 4.0), veer=veer)
    lever = complex(*offset[:2]) * np.exp(-1j * offset[2])
    fit = fit_axes(driven, np.array([lever.real, lever.imag]))
    assert abs(math.remainder(fit.turn + offset[2], math.tau)) < 1e-9
    assert fit.scale == pytest.approx(scale)
    assert abs(fit.robot_bias - bias * np.exp(-1j * offset[2])) < 1e-9
    assert abs(fit.room_bias - drift) < 1e-9
    assert not fit.mirrored


def test_by_hand_strokes_at_one_heading_mirrored_of_a_robot_that_stays_and_of_one_axis():
    fit = fit_axes(strokes(bias=0.02, drift=0.01j), ORIGIN)
    assert (fit.robot_bias, fit.room_bias) == (pytest.approx(0.02 + 0.01j), 0.0)
    fit = fit_axes(strokes((0.0, 0.0, 0.4), mirror=True, yaws=(0.0, 2.0)), ORIGIN)
    assert (fit.mirrored, fit.scale) == (True, pytest.approx(1.0))
    fit = fit_axes(strokes(scale=0.0), ORIGIN)
    assert (fit.scale, fit.mirrored) == (0.0, False)
    fit = fit_axes(strokes((0.0, 0.0, 0.4), drift=0.02)[:2], ORIGIN)
    assert (fit.turn, fit.uncertainty, fit.mirrored) == (pytest.approx(-0.4), math.inf, False)


def test_the_uncertainty_is_that_of_many_fits():
    random = np.random.default_rng(1)

    def walked():
        return 0.0134 * complex(*random.standard_normal(2))

    fits = [fit_axes(strokes((0.0, 0.0, -0.2), yaws=(0.0, 2.0, 4.0), noise=walked), ORIGIN) for _ in range(300)]
    told = np.sqrt(np.mean([fit.uncertainty**2 for fit in fits]))
    assert np.std([fit.turn for fit in fits]) == pytest.approx(told, rel=0.12)
    assert np.std([fit.scale for fit in fits]) == pytest.approx(told, rel=0.12)
    biases = np.array([fit.room_bias for fit in fits])
    told = np.sqrt(np.mean([fit.bias_uncertainty**2 for fit in fits]))
    assert np.sqrt(0.5 * np.mean(np.abs(biases) ** 2)) == pytest.approx(told, rel=0.12)


LAG = 0.1
short_turn = st.complex_numbers(max_magnitude=0.2, allow_nan=False)
BOTH_WAYS = (1.0, 1.0, -1.0, -1.0)


def turned(rate, lever, *, drift=0.0, bias=0.0, heading=0.3, walk=None, noise=None):
    """A turn of a robot at `heading`; drift in the room and bias in the body's frame [m/s], as complex numbers."""
    duration = 3.3
    times = 0.01 * np.arange(1, round(100 * duration) + 1)
    yaws = heading + rate * times
    centres = drift * times + bias * np.exp(1j * yaws) / (1j * rate * (1.0 + 1j * rate * LAG))
    centres = centres + (0.0 if walk is None else walk(len(times)))
    seen = centres + lever * np.exp(1j * yaws) + (0.0 if noise is None else noise(len(times)))
    poses = [
        PoseSample(t, np.array([z.real, z.imag]), math.remainder(yaw, math.tau))
        for t, z, yaw in zip(times.tolist(), seen.tolist(), yaws.tolist(), strict=True)
    ]
    return FittedTurn(rate, poses)


def complex_lever(fit):
    return complex(*fit.lever.tolist())


@given(lever=short_turn, drift=slow, bias=slow, heading=st.floats(-3.0, 3.0), fast=st.floats(1.0, 3.0))
def test_the_lever_is_found_exactly_in_spite_of_both_biases(lever, drift, bias, heading, fast):
    turns = [turned(fast * way, lever, drift=drift, bias=bias, heading=heading) for way in BOTH_WAYS]
    assert abs(complex_lever(fit_turns(turns, LAG)) - lever) < 1e-6


def test_a_short_turn_tells_no_lever():
    turn = turned(1.0, 0.04)
    assert fit_turns([replace(turn, poses=turn.poses[:35])], LAG).uncertainty == math.inf


def test_the_uncertainty_of_a_lever_is_that_of_many_fits():
    """Of wheels whose velocity errs by 0.06 m/s for 0.05 s each, 0.0134 m in a second, behind a lag."""
    random, keeps = np.random.default_rng(1), math.exp(-0.01 / LAG)

    def walked(n):
        errors = 0.06 * (random.standard_normal(n // 5 + 1) + 1j * random.standard_normal(n // 5 + 1))
        return 0.01 * np.cumsum(lfilter([1.0 - keeps], [1.0, -keeps], np.repeat(errors, 5)[:n]))

    def noisy(n):
        return 0.002 * (random.standard_normal(n) + 1j * random.standard_normal(n))

    lever = cmath.rect(0.04, 0.5)
    turns = [[turned(way, lever, walk=walked, noise=noisy) for way in BOTH_WAYS] for _ in range(50)]
    fits = [fit_turns(four, LAG) for four in turns]
    errors = np.array([complex_lever(fit) - lever for fit in fits])
    told = np.sqrt(np.mean([fit.uncertainty**2 for fit in fits]))
    # 50 fits of two axes: 10 in 100 is one standard deviation of this ratio
    assert np.sqrt(0.5 * np.mean(np.abs(errors) ** 2)) / told == pytest.approx(1.0, abs=0.3)


metres = st.floats(-20.0, 20.0)
offsets = st.floats(-1.0, 1.0)
turns = st.floats(-math.pi, math.pi)


def measured(position=(0.0, 0.0, 0.0), quaternion=(0.0, 0.0, 0.0, 1.0), frame="map", stamp=1.0):
    return MeasuredPose(frame, stamp, tuple(position), tuple(quaternion))


def about(axis, angle):
    return (*(math.sin(angle / 2) * np.array(axis)), math.cos(angle / 2))


def same_angle(a, b, tolerance=1e-9):
    return abs(math.remainder(a - b, math.tau)) < tolerance


def test_an_offset_by_hand_and_what_has_no_stamp_gets_the_time_of_its_receipt():
    body = with_offset(PoseSample(0.0, np.array([1.0, 2.0]), math.pi / 2), 0.03, 0.01, math.pi / 2)
    np.testing.assert_allclose(body.position, [0.99, 2.03], atol=1e-12)
    assert [robot_pose(measured(stamp=stamp), 7.5, Mocap()).stamp for stamp in (None, 3.0)] == [7.5, 3.0]
    assert same_angle(body.yaw, math.pi)


@given(metres, metres, turns, offsets, offsets, turns, st.sampled_from(["m", "mm"]), st.sampled_from(["z_up", "y_up"]))
def test_what_a_motion_capture_measures_of_a_robot_is_undone(x, y, yaw, ahead, left, turned, units, axes):
    body = with_offset(PoseSample(1.0, np.array([x, y]), yaw), ahead, left, turned)
    scale = {"m": 1.0, "mm": 1000.0}[units]
    (px, py), height = scale * body.position, scale * 0.1
    if axes == "y_up":
        seen = measured((px, height, -py), about((0, 1, 0), body.yaw))
    else:
        seen = measured((px, py, height), about((0, 0, 1), body.yaw))
    mocap = Mocap(units=units, axes=axes, body_offset_x=ahead, body_offset_y=left, body_offset_yaw=turned)
    found = robot_pose(seen, 0.0, mocap)
    np.testing.assert_allclose(found.position, [x, y], atol=1e-9)
    assert same_angle(found.yaw, yaw)


def test_a_tilted_floor_is_no_height():
    uphill = measured((1.0, -2.0, 0.1 + math.tan(0.05) + 2.0 * math.tan(0.02)))
    assert robot_pose(uphill, 0.0, Mocap(floor_tilt=(0.05, -0.02))).height == pytest.approx(0.1)
    with pytest.raises(ParameterError, match="two slopes"):
        Mocap(floor_tilt=(0.05,))


def test_lost_bodies_stay_lost_in_any_axes():
    table = [
        ("zeros", measured(quaternion=(0.0, 0.0, 0.0, 0.0))),
        ("not_finite", measured(quaternion=(math.nan,) * 4)),
        ("not_finite", measured((0.0, math.nan, 0.0))),
        ("quaternion", measured((1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 0.0))),
    ]
    for axes, (reason, pose) in product(("z_up", "y_up"), table):
        with pytest.raises(PoseError) as error:
            robot_pose(pose, 0.0, Mocap(axes=axes, units="mm", body_offset_x=0.1))
        assert error.value.reason == reason


def test_a_repeated_pose_is_told_by_its_last_bit():
    first = measured((1.0, 2.0, 0.0), stamp=1.0)
    assert measured((1.0, 2.0, 0.0), stamp=1.01).repeats(first)
    assert not measured((math.nextafter(1.0, 2.0), 2.0, 0.0)).repeats(first)
    assert not measured((1.0, 2.0, 0.0), about((0, 0, 1), 1e-9)).repeats(first)
    assert not first.repeats(None)
