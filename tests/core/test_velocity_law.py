"""The robot's velocity law: against its differential equation, its symmetries, and the command that it answers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Robot
from collplan_core.velocity_law import SHORTEST_LAG, command_lead, velocity_after, velocity_law
from scenes import rotation, unit

FEW = settings(max_examples=15)
STEP = 0.025
ROBOT = Robot()
LAW = velocity_law(ROBOT, STEP)
SPEED = ROBOT.max_speed
angles = st.floats(-np.pi, np.pi)
velocities = st.tuples(st.floats(0.0, SPEED), angles).map(lambda v: v[0] * unit(v[1]))
durations = st.floats(0.0, 0.3)


def after(velocity, command, duration: float, law=LAW) -> np.ndarray:
    return np.array(velocity_after(law, *map(float, velocity), *map(float, command), duration))


@FEW
@given(v=velocities, u=velocities, duration=durations)
def test_the_wheels_follow_their_equation(v, u, duration):
    """dv/dt = sat((u - v) / lag), by a thousand steps of the midpoint rule."""

    def rate(velocity: np.ndarray) -> np.ndarray:
        wanted = (u - velocity) / LAW.lag
        return wanted / max(1.0, np.hypot(*wanted) / LAW.max_acceleration)

    expected, h = v.copy(), duration / 1000
    for _ in range(1000):
        expected = expected + h * rate(expected + 0.5 * h * rate(expected))
    np.testing.assert_allclose(after(v, u, duration), expected, atol=2e-5)
    # the step that is quick changes nothing
    np.testing.assert_allclose(after(v, u, STEP, velocity_law(ROBOT)), after(v, u, STEP), atol=1e-15)


@given(v=velocities, u=velocities, duration=durations, turn=angles)
def test_the_wheels_never_overshoot_and_have_no_direction(v, u, duration, turn):
    came = after(v, u, duration)
    assert np.hypot(*(came - v)) <= LAW.max_acceleration * duration + 1e-12
    assert np.hypot(*(came - v)) + np.hypot(*(u - came)) == pytest.approx(np.hypot(*(u - v)), abs=1e-12)
    np.testing.assert_allclose(
        after(rotation(turn) @ v, rotation(turn) @ u, duration), rotation(turn) @ came, atol=1e-12
    )


def test_by_hand_full_acceleration_then_a_first_order_lag():
    np.testing.assert_allclose(after((0.0, 0.0), (1.2, 0.0), STEP), (1.5 * STEP, 0.0), atol=1e-12)
    # 0.15 m/s is what the lag makes of full acceleration: reached after 0.1 s
    np.testing.assert_allclose(after((0.9, 0.0), (1.2, 0.0), 0.2), (1.2 - 0.15 * np.exp(-1.0), 0.0), atol=1e-12)
    np.testing.assert_allclose(after((1.1, 0.0), (1.2, 0.0), STEP), (1.2 - 0.1 * np.exp(-0.25), 0.0), atol=1e-12)


@given(lead=st.floats(1e-3, 2.0), duration=st.floats(0.005, 0.3))
def test_the_lead_is_what_the_command_was_ahead_by(lead, duration):
    """Where the acceleration is full all the time, every larger lead would do: the smallest one is found."""
    change = after((0.0, 0.0), (lead, 0.0), duration)[0]
    found = command_lead(LAW, change, duration)
    assert found <= lead + 1e-5
    np.testing.assert_allclose(after((0.0, 0.0), (found, 0.0), duration)[0], change, atol=1e-5)


def test_no_lag_at_all_is_a_very_short_one():
    law = velocity_law(Robot(velocity_lag=0.0))
    assert law.lag == SHORTEST_LAG
    np.testing.assert_allclose(after((0.0, 0.0), (0.1, 0.0), 0.1, law), (0.1, 0.0), atol=1e-9)
