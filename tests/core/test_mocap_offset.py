"""The body's place on the robot, found from exact and from noisy motions."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.calibration.mocap_offset import body_offset, displacement, fit_axes, fit_lever, mean_pose
from collplan_core.calibration.stream_quality import stream_quality
from collplan_core.sensing.mocap_body import with_offset
from collplan_core.sensing.pose_filter import PoseSample

FEW = settings(derandomize=True, deadline=None, max_examples=30)
short = st.floats(-0.2, 0.2)
angles = st.floats(-3.1, 3.1)
MOVES = 0.1 * np.array([(1, 0), (-1, 0), (0, 1), (0, -1)])


def turned(angle):
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def seen(offset, positions, yaws):
    """The body's poses while the robot has these."""
    return [
        with_offset(PoseSample(0.01 * k, np.asarray(p, dtype=float), float(yaw)), *offset)
        for k, (p, yaw) in enumerate(zip(positions, yaws, strict=True))
    ]


def turning(offset, drift=(0.0, 0.0), span=2 * math.pi):
    yaws = np.linspace(0.3, 0.3 + span, 200)
    return seen(offset, np.outer(np.linspace(0, 1, 200), drift) + np.array([1.0, 2.0]), yaws)


@given(st.tuples(short, short, angles), angles, st.tuples(short, short))
@FEW
def test_the_offset_is_found(offset, yaw, drift):
    """Exactly, whatever the robot's heading, and although it drifts while it turns."""
    lever = fit_lever(turning(offset, drift))
    measured = []
    for move in MOVES:
        before, after = seen(offset, [(0.0, 0.0), turned(yaw) @ move], [yaw, yaw])
        measured.append(displacement(before, after, lever))
    axes = fit_axes(MOVES, np.array(measured))
    found = body_offset(axes, lever)
    assert (found.x, found.y) == pytest.approx(offset[:2], abs=1e-9)
    assert abs(math.remainder(found.yaw - offset[2], math.tau)) < 1e-9
    assert axes.scale == pytest.approx(1.0)
    assert not axes.mirrored


def test_half_a_turn_will_do():
    np.testing.assert_allclose(fit_lever(turning((0.04, -0.02, 0.0), span=math.pi)), [0.04, -0.02], atol=1e-9)


@given(st.tuples(short, short, angles), st.floats(-0.2, 0.2))
@FEW
def test_a_robot_that_turns_a_little_while_it_drives(offset, more):
    """The body's own path would mislead."""
    before, after = seen(offset, [(0.0, 0.0), (0.1, 0.0)], [0.0, more])
    lever = turned(-offset[2]) @ offset[:2]
    went = displacement(before, after, lever)
    np.testing.assert_allclose(turned(offset[2]) @ went, [0.1, 0.0], atol=1e-12)


def test_uncertainty_is_that_of_many_fits():
    random = np.random.default_rng(1)
    fits = [fit_axes(MOVES, MOVES @ turned(0.2).T + random.normal(0.0, 0.001, MOVES.shape)) for _ in range(400)]
    assert np.std([fit.turn for fit in fits]) == pytest.approx(0.001 / 0.2, rel=0.1)
    assert np.sqrt(np.mean([fit.uncertainty**2 for fit in fits])) == pytest.approx(0.001 / 0.2, rel=0.1)
    assert np.mean([fit.turn for fit in fits]) == pytest.approx(0.2, abs=0.001)


def test_left_for_right_is_noticed():
    assert fit_axes(MOVES, MOVES * (1, -1) @ turned(0.4).T).mirrored


def test_millimetres_taken_for_metres_are_noticed():
    assert fit_axes(MOVES, 1000.0 * MOVES).scale == pytest.approx(1000.0)


def test_a_robot_that_stays_has_no_scale():
    fit = fit_axes(MOVES, np.zeros((4, 2)))
    assert fit.scale == 0.0
    assert not fit.mirrored


def test_a_common_drift_is_no_turn():
    fit = fit_axes(MOVES, MOVES + np.array([0.03, -0.02]))
    assert (fit.turn, fit.scale) == pytest.approx((0.0, 1.0))


def test_mean_pose_across_the_back():
    mean = mean_pose([PoseSample(0.0, np.zeros(2), math.pi - 0.1), PoseSample(1.0, np.ones(2), -math.pi + 0.1)])
    assert abs(mean.yaw) == pytest.approx(math.pi)
    assert (mean.stamp, mean.position.tolist()) == (1.0, [0.5, 0.5])


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
