"""With which velocity a new plan begins: measured, foreseen, or between them."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from collplan_core.state import State
from collplan_core.time_to_goal_planner.initial_state import SURPRISE, UNDETECTED, Expected, initial_velocity
from scenes import unit
from time_to_goal_scenes import SETTINGS

CONTACT = 1.5
BEFORE, AFTER = np.array([1.0, 0.2]), np.array([-0.7, 0.16])
LAG = 0.5 * SETTINGS.mocap.velocity_window
STEADY = np.array([0.8, -0.3])


def expecting(velocity_at, times, contact_times=()) -> Expected:
    times = np.asarray(times, dtype=float)
    velocities = np.array([velocity_at(t) for t in times])
    steps = 0.5 * (velocities[1:] + velocities[:-1]) * np.diff(times)[:, None]
    return Expected(
        times, np.vstack([np.zeros(2), np.cumsum(steps, axis=0)]), velocities, np.array(contact_times, dtype=float)
    )


DRIVING = expecting(lambda t: STEADY, np.arange(1.0, 2.01, 0.025))
ACCELERATING = expecting(lambda t: np.array([1.5 * (t - 1.0), 0.0]), np.arange(1.0, 1.8, 0.025))
BOUNCING = expecting(
    lambda t: AFTER if t >= CONTACT else BEFORE, np.sort([*np.arange(1.0, 2.01, 0.025), CONTACT + 1e-9]), [CONTACT]
)


def initial(stamp: float, velocity, expected: Expected | None) -> np.ndarray:
    return initial_velocity(State(stamp, np.zeros(2), np.array(velocity, dtype=float), 0.0), expected, SETTINGS.mocap)


def test_without_an_expectation_the_measurement_counts():
    np.testing.assert_allclose(DRIVING.positions_at(np.array([0.0, 1.5, 5.0])), np.outer((0.0, 0.5, 1.0), STEADY))
    for stamp, expected in ((1.5, None), (0.9, DRIVING), (2.1, DRIVING), (-5.0, DRIVING)):
        np.testing.assert_array_equal(initial(stamp, (0.3, 0.1), expected), (0.3, 0.1))


@given(stamp=st.floats(1.05, 1.95), off=st.floats(0.0, 2.0), bearing=st.floats(-np.pi, np.pi))
def test_as_expected_it_is_between_the_foreseen_and_the_measured_one_and_a_surprise_counts_as_measured(
    stamp, off, bearing
):
    assume(abs(off - SURPRISE) > 1e-6)
    begun = initial(stamp, STEADY + off * unit(bearing), DRIVING)
    np.testing.assert_allclose(begun, STEADY + (0.5 if off < SURPRISE else 1.0) * off * unit(bearing), atol=1e-9)


def test_the_filter_s_delay_is_made_up_for():
    late = 1.5 * (0.4 - LAG)
    assert initial(1.4, (late, 0.0), ACCELERATING) == pytest.approx((1.5 * 0.4, 0.0), abs=1e-9)


def test_after_a_foreseen_contact_the_rebound_is_believed_until_it_should_have_left_a_trace():
    for age in (0.001, 0.02, 0.99 * UNDETECTED):
        np.testing.assert_allclose(initial(CONTACT + age, BEFORE, BOUNCING), AFTER, atol=1e-9)
    np.testing.assert_array_equal(initial(CONTACT + 1.01 * UNDETECTED, BEFORE, BOUNCING), BEFORE)


@given(age=st.floats(0.001, 2 * LAG + UNDETECTED - 0.001), off=st.floats(0.0, 0.5), bearing=st.floats(-np.pi, np.pi))
def test_a_rebound_once_seen_is_believed_more_and_more(age, off, bearing):
    measured = AFTER + off * unit(bearing)
    away = (initial(CONTACT + age, measured, BOUNCING) - AFTER) @ unit(bearing)
    assert 0.0 <= away <= 0.5 * off + 1e-9
    assert away <= (initial(CONTACT + age + 0.001, measured, BOUNCING) - AFTER) @ unit(bearing) + 1e-9


def test_before_the_contact_it_does_not_count():
    for measured in (BEFORE, AFTER, (0.0, 0.0), (-1.2, 1.2)):
        begun = initial(CONTACT - 0.03, measured, BOUNCING)
        off = np.hypot(*(np.array(measured) - BEFORE))
        np.testing.assert_allclose(begun, BEFORE if off < SURPRISE else measured, atol=1e-9)
