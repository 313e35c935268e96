"""The point about which a robot turns, found from exact and from noisy turns."""

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.calibration.turn_fit import Turn, fit_turns
from collplan_core.sensing.pose_filter import PoseSample

FEW = settings(derandomize=True, deadline=None, max_examples=20)
LAG = 0.1
short = st.complex_numbers(max_magnitude=0.2, allow_nan=False)
slow = st.complex_numbers(max_magnitude=0.05, allow_nan=False)
BOTH_WAYS = (1.0, 1.0, -1.0, -1.0)


def turned(rate, lever, *, drift=0.0, bias=0.0, share=1.0, heading=0.3, walk=None, noise=None):
    """A turn of a robot at `heading`; drift in the room and bias in the body's frame [m/s], as complex numbers."""
    duration = 3.3
    times = 0.01 * np.arange(1, round(100 * duration) + 1)
    yaws = heading + share * rate * times
    centres = drift * times + bias * np.exp(1j * yaws) / (1j * share * rate * (1.0 + 1j * share * rate * LAG))
    centres = centres + (0.0 if walk is None else walk(len(times)))
    seen = centres + lever * np.exp(1j * yaws) + (0.0 if noise is None else noise(len(times)))
    poses = [
        PoseSample(t, np.array([z.real, z.imag]), math.remainder(yaw, math.tau))
        for t, z, yaw in zip(times.tolist(), seen.tolist(), yaws.tolist(), strict=True)
    ]
    before = PoseSample(0.0, poses[0].position, heading)
    return Turn(rate, duration, before, poses, poses[-1])


def complex_lever(fit):
    return complex(*fit.lever.tolist())


@given(lever=short, drift=slow, bias=slow, heading=st.floats(-3.0, 3.0), fast=st.floats(1.0, 3.0))
@FEW
def test_the_lever_is_found_exactly_in_spite_of_both_biases(lever, drift, bias, heading, fast):
    turns = [turned(fast * way, lever, drift=drift, bias=bias, heading=heading) for way in BOTH_WAYS]
    assert abs(complex_lever(fit_turns(turns, LAG)) - lever) < 1e-6


def test_turns_one_way_take_the_robots_bias_for_a_lever():
    bias = 0.02 + 0.01j
    wrong = complex_lever(fit_turns([turned(1.0, 0.0, bias=bias), turned(1.0, 0.0, bias=bias)], LAG))
    assert abs(wrong - bias / (1j * (1.0 + 1j * LAG))) < 1e-6


def test_the_share_of_the_angle_is_found():
    for share in [0.9, 1.0, 1.2, -1.0, 0.0]:
        fit = fit_turns([turned(way, 0.04, share=share or 1e-6) for way in BOTH_WAYS], LAG)
        assert fit.share == pytest.approx(share, abs=1e-5), share
        assert fit.share_uncertainty < 1e-6, share


def test_one_turn_has_no_spread_and_a_short_one_no_lever():
    assert fit_turns([turned(1.0, 0.04)], LAG).share_uncertainty == math.inf
    turn = turned(1.0, 0.04)
    assert fit_turns([replace(turn, duration=0.35, poses=turn.poses[:35])], LAG).uncertainty == math.inf


@pytest.mark.parametrize("walk", [0.0, 0.0134])
def test_the_uncertainty_is_that_of_many_fits(walk):
    """Of wheels whose velocity errs by 0.06 m/s for 0.05 s each, 0.0134 m in a second, behind a lag."""
    random = np.random.default_rng(1)

    def walked(n):
        velocity, position, positions = 0.0j, 0.0j, []
        for k in range(n):
            if k % 5 == 0:
                error = walk * math.sqrt(20.0) * complex(*random.standard_normal(2))
            velocity += (error - velocity) * (1.0 - math.exp(-0.01 / LAG))
            position += 0.01 * velocity
            positions.append(position)
        return np.array(positions)

    def noisy(n):
        return 0.002 * (random.standard_normal(n) + 1j * random.standard_normal(n))

    lever = cmath.rect(0.04, 0.5)
    turns = [[turned(way, lever, walk=walked, noise=noisy) for way in BOTH_WAYS] for _ in range(50)]
    fits = [fit_turns(four, LAG) for four in turns]
    errors = np.array([complex_lever(fit) - lever for fit in fits])
    told = np.sqrt(np.mean([fit.uncertainty**2 for fit in fits]))
    # 50 fits of two axes: 10 in 100 is one standard deviation of this ratio
    assert np.sqrt(0.5 * np.mean(np.abs(errors) ** 2)) / told == pytest.approx(1.0, abs=0.3)
