"""How a robot follows its commands, found from exact and from noisy straight motions."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.calibration.stroke_fit import Stroke, centre, fit_axes
from collplan_core.sensing.mocap_body import with_offset
from collplan_core.sensing.pose_filter import PoseSample

FEW = settings(derandomize=True, deadline=None, max_examples=30)
short = st.floats(-0.2, 0.2)
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


def lever_of(offset):
    x, y, yaw = offset
    lever = complex(x, y) * np.exp(-1j * yaw)
    return np.array([lever.real, lever.imag])


@given(st.tuples(short, short, angles), st.floats(0.5, 2.0), slow, slow, angles, st.floats(-0.2, 0.2))
@FEW
def test_turn_scale_and_biases_are_found(offset, scale, bias, drift, yaw, veer):
    """Exactly, whatever the heading, and although it veers while it drives."""
    driven = strokes(offset, scale=scale, bias=bias, drift=drift, yaws=(yaw, yaw + 2.0, yaw + 4.0), veer=veer)
    fit = fit_axes(driven, lever_of(offset))
    assert abs(math.remainder(fit.turn + offset[2], math.tau)) < 1e-9
    assert fit.scale == pytest.approx(scale)
    assert abs(fit.robot_bias - bias * np.exp(-1j * offset[2])) < 1e-9
    assert abs(fit.room_bias - drift) < 1e-9
    assert not fit.mirrored


def test_at_one_heading_both_biases_are_one():
    fit = fit_axes(strokes(bias=0.02, drift=0.01j), ORIGIN)
    assert (fit.robot_bias, fit.room_bias) == (pytest.approx(0.02 + 0.01j), 0.0)
    assert (fit.turn, fit.scale) == pytest.approx((0.0, 1.0))


def test_left_for_right_is_noticed():
    fit = fit_axes(strokes((0.0, 0.0, 0.4), mirror=True, yaws=(0.0, 2.0)), ORIGIN)
    assert fit.mirrored
    assert fit.scale == pytest.approx(1.0)


def test_a_robot_that_stays_has_no_scale():
    fit = fit_axes(strokes(scale=0.0), ORIGIN)
    assert (fit.scale, fit.mirrored) == (0.0, False)


def test_forward_and_back_alone_say_the_turn_but_not_how_certain_it_is():
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
    assert np.mean([fit.turn for fit in fits]) == pytest.approx(0.2, abs=0.01)
    biases = np.array([fit.room_bias for fit in fits])
    told = np.sqrt(np.mean([fit.bias_uncertainty**2 for fit in fits]))
    assert np.sqrt(0.5 * np.mean(np.abs(biases) ** 2)) == pytest.approx(told, rel=0.12)


@given(st.tuples(short, short, angles), angles)
@FEW
def test_the_centre_is_that_of_the_robot(offset, yaw):
    seen = with_offset(PoseSample(0.0, np.array([1.0, 2.0]), yaw), *offset)
    assert abs(centre(seen, lever_of(offset)) - (1.0 + 2.0j)) < 1e-12
