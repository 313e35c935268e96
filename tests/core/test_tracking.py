"""PID, look-ahead, saturation, heading, what a robot makes of a command, and what the controller says it does."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from collplan_core.control.follow import INTEGRAL_LIMIT, K_I, clip_command, hold_heading, pid
from collplan_core.control.reference import found_reference, sample_reference
from collplan_core.parameters import Control, Limits, Robot
from collplan_core.velocity_bounds import velocity_bounds
from scenes import unit

CONTROL, ROBOT, LIMITS = Control(), Robot(), Limits()
BOUNDS = velocity_bounds(ROBOT)
ZERO = np.zeros(2)
angles = st.floats(-20.0, 20.0)


@given(yaw=angles, held=angles)
def test_the_heading_is_held_the_short_way(yaw, held):
    rate = hold_heading(yaw, held)
    error = (held - yaw + np.pi) % (2 * np.pi) - np.pi
    assert abs(rate) <= ROBOT.max_yaw_rate + 1e-12
    if abs(abs(error) - np.pi) > 1e-9:
        assert rate * error >= 0.0
        assert abs(rate) == pytest.approx(min(2.0 * abs(error), abs(hold_heading(0.0, 3.0))), abs=1e-9)


def test_by_hand_a_command_is_cut_to_the_most_and_refused_beyond_half_as_much_again_or_if_it_is_not_finite():
    v, most = ROBOT.max_speed * unit(0.3), ROBOT.max_yaw_rate
    for factor in (0.0, 0.5, 1.0, 1.2, 1.499):
        velocity, yaw_rate = clip_command(factor * v, -factor * most, ROBOT, LIMITS)
        np.testing.assert_allclose(velocity, min(factor, 1.0) * v, atol=1e-12)
        assert yaw_rate == pytest.approx(-min(factor, 1.0) * most)
    bad = [(1.501 * v, 0.1), (ZERO, 1.501 * most)]
    for number in (np.nan, np.inf, -np.inf):
        bad += [(np.array([number, 0.0]), 0.0), (np.array([0.0, number]), 0.0), (ZERO, number)]
    assert [clip_command(*command, ROBOT, LIMITS) for command in bad] == [None] * 11


def run_pid(control: Control, error, steps: int, forward=ZERO):
    integral = ZERO
    for _ in range(steps):
        command, integral = pid(np.array(error), forward, forward, forward, integral, control, ROBOT, BOUNDS)
    return command, integral


def test_by_hand_pid():
    control = replace(CONTROL, k_p=1.0)
    given_ = [0.04, 0.0], [0.2, 0.1], [0.2, 0.2], [0.2, 0.1], [0.05, 0.0]
    command, integral = pid(*map(np.array, given_), control, ROBOT, BOUNDS)
    aside = K_I * 0.02 * 0.05
    np.testing.assert_allclose(integral, [0.05 + aside, -aside])
    np.testing.assert_allclose(command, [0.2 + 0.04 + 0.05 + aside, 0.1 - aside])


def test_the_integral_does_not_grow_along_what_is_cut_off_and_never_exceeds_its_limit():
    control = replace(CONTROL, k_p=1.0)
    _, wound = run_pid(control, [0.5, 0.0], 200)  # the wheels are at their largest acceleration
    assert np.hypot(*wound) <= ROBOT.max_acceleration * ROBOT.velocity_lag
    command, wound = run_pid(control, [0.05, 0.02], 200, np.array([ROBOT.max_speed, 0.0]))
    assert np.hypot(*command) == pytest.approx(ROBOT.max_speed)
    assert wound[0] < 0.02 < 0.1 < wound[1]
    full = np.array([INTEGRAL_LIMIT, 0.0])
    _, limited = pid(np.array([0.02, 0.0]), ZERO, ZERO, full, full, control, ROBOT, BOUNDS)
    np.testing.assert_allclose(limited, full)


TIMES = np.linspace(10.0, 11.0, 65)
PARABOLA = found_reference(TIMES, np.stack([(TIMES - 10.0) ** 2 / 2, TIMES - 10.0], axis=1), 1.5)


@given(now=st.floats(10.0, 10.8))
def test_position_and_velocity_are_those_of_the_reference_now(now):
    position, velocity = sample_reference(PARABOLA, now)
    np.testing.assert_allclose(position, [(now - 10.0) ** 2 / 2, now - 10.0], atol=1e-4)
    np.testing.assert_allclose(velocity, [now - 10.0, 1.0], atol=0.02)


def test_the_reference_rests_at_its_end_once_past():
    position, velocity = sample_reference(PARABOLA, 11.01)
    np.testing.assert_allclose(position, PARABOLA.positions[-1])
    assert not velocity.any()
    position, _ = sample_reference(PARABOLA, 9.0)
    np.testing.assert_allclose(position, PARABOLA.positions[0])
