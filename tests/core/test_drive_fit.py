"""max_acceleration and lag from poses of a drive that is known."""

import os

import numpy as np
import pytest

from collplan_core.calibration.drive_fit import DrivenStretches, fit_drive
from collplan_core.calibration.fitted_constant import TooLittle, Unexplained
from collplan_core.parameters import Robot
from collplan_core.velocity_law import velocity_after, velocity_law

NOISE, PERIOD = 0.002, 0.05
COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") == "0"
compiled = pytest.mark.skipif(not COMPILED, reason="takes minutes without the compiler")


def driven(acceleration, lag, seed, duration=30.0, error=0.06, bias=0.03, leap=1.0):
    """Poses of a robot whose command leaps within +- `leap` [m/s] every half second, in stretches of three seconds."""
    random, law = np.random.default_rng(seed), velocity_law(Robot(max_acceleration=acceleration, velocity_lag=lag))
    times = 0.01 * np.arange(round(100 * duration))
    wanted = np.repeat(random.uniform(-leap, leap, (len(times) // 50 + 1, 2)), 50, axis=0)[: len(times)]
    errors = np.repeat(random.normal(0.0, error, (len(times) // 5 + 1, 2)), 5, axis=0)[: len(times)]
    aimed = wanted + errors + random.normal(0.0, bias, 2)
    position, velocity, points = np.zeros(2), np.zeros(2), []
    for aim in aimed:
        points.append(position)
        for _ in range(10):
            before = velocity
            velocity = np.array(velocity_after(law, *velocity, *aim, 0.001))
            position = position + 0.0005 * (before + velocity)
    measured = np.array(points) + random.normal(0.0, NOISE, (len(times), 2))
    ends = np.arange(0, len(times) + 1, 300)
    return DrivenStretches(
        f"run {seed}", times, measured, wanted, np.stack([ends[:-1], ends[1:]], axis=1), PERIOD, NOISE
    )


@compiled
def test_the_drive_is_found():
    for acceleration, lag in ((1.5, 0.1), (3.0, 0.05)):
        fit = fit_drive([driven(acceleration, lag, seed) for seed in (0, 1)])
        assert fit.max_acceleration.value == pytest.approx(acceleration, rel=0.02)
        assert fit.velocity_lag.value == pytest.approx(lag, abs=0.03)
        assert fit.wheel_error == pytest.approx(0.06, rel=0.4)
        for constant in (fit.max_acceleration, fit.velocity_lag):
            assert constant.low < constant.value < constant.high


@compiled
def test_the_bias_of_each_run_is_found():
    biased = driven(1.5, 0.1, 3, bias=0.0)
    shifted = biased.wanted - [0.1, -0.05]
    run = DrivenStretches("run", biased.times, biased.points, shifted, biased.stretches, PERIOD, NOISE)
    assert fit_drive([run]).biases[0] == pytest.approx((0.1, -0.05), abs=0.03)


@compiled
def test_too_little_driving_and_what_is_no_such_drive_are_refused():
    run = driven(1.5, 0.1, 0)
    other = DrivenStretches("run", run.times, run.points, run.wanted[:, ::-1].copy(), run.stretches, PERIOD, NOISE)
    table = [
        ([driven(1.5, 0.1, 0, duration=9.0)], TooLittle, "10 s"),
        ([driven(3.0, 0.2, 0, leap=0.1)], TooLittle, "changes"),
        ([other], Unexplained, "drive law"),
        ([run, driven(1.5, 0.1, 1), driven(0.9, 0.1, 2)], Unexplained, ""),
    ]
    for runs, error, words in table:
        with pytest.raises(error, match=words):
            fit_drive(runs)
