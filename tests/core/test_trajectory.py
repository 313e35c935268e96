"""Waypoints, duration and spline. Paper: III-A."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from collplan_core.paper_planner.trajectory import (
    LONGEST_HANDLE,
    WAYPOINTS,
    TimeLaw,
    chord_waypoints,
    clamped_waypoints,
    spline,
)
from collplan_core.parameters import Robot
from collplan_core.velocity_bounds import velocity_bounds

V_MAX, T_MAP, P_SAFE, A_MAX = 1.2, 0.2, 1.3, 3.0
LIMITED = TimeLaw(velocity_bounds(Robot(max_speed=V_MAX)), T_MAP, P_SAFE, V_MAX, A_MAX)
AS_PRINTED = LIMITED._replace(peak_speed=np.inf, peak_acceleration=np.inf)
SHARE = np.linspace(0.0, 1.0, 64)

points = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)).map(np.array)
# a measured velocity may exceed v_max a little
velocities = st.tuples(st.floats(0.0, 1.5), st.floats(-4.0, 4.0)).map(
    lambda p: p[0] * np.array([np.cos(p[1]), np.sin(p[1])])
)
controls = st.lists(points, min_size=4, max_size=4).map(np.array)
ZERO, X = np.zeros(2), np.array([1.0, 0.0])
SLOW_TO_CONVERGE = {"start": ZERO, "v": -0.5 * X, "end": 1.4 * X, "v_s": -0.4 * X}
"""Both velocities point away from the aim: T and the handles lengthen each other round by round."""


def trajectory(start, velocity, end, end_velocity, waypoints="clamped", law=LIMITED):
    return WAYPOINTS[waypoints](start, velocity, end, end_velocity, law)


def eq_4(control) -> float:
    """T = max(T_v, T_map), with T_v of eq. (5)."""
    return max(T_MAP, P_SAFE * np.hypot(*np.diff(control, axis=0).T).sum() / V_MAX)


@given(control=controls)
def test_the_spline_is_scipys_clamped_cubic_b_spline(control):
    oracle = BSpline(np.repeat([0.0, 1.0], 4), control, 3)
    position, derivative = spline(control, SHARE)
    np.testing.assert_allclose(position, oracle(SHARE), atol=1e-12)
    np.testing.assert_allclose(derivative, oracle.derivative()(SHARE), atol=1e-11)


@given(start=points, v=velocities, end=points, v_s=velocities, waypoints=st.sampled_from(["clamped", "chord"]))
@example(start=ZERO, v=ZERO, end=ZERO, v_s=ZERO, waypoints="clamped")
@example(start=ZERO, v=1.2 * X, end=-0.6 * X, v_s=1.2 * X, waypoints="clamped")
def test_no_reference_is_beyond_the_motors(start, v, end, v_s, waypoints):
    control, duration = trajectory(start, v, end, v_s, waypoints)
    oracle = BSpline(np.repeat([0.0, 1.0], 4), control, 3)
    dense = np.linspace(0.0, 1.0, 1000)
    assert np.hypot(*oracle.derivative()(dense).T).max() / duration <= V_MAX * (1 + 1e-3)
    assert np.hypot(*oracle.derivative(2)(dense).T).max() / duration**2 <= A_MAX * (1 + 1e-6)
    assert duration >= T_MAP
    np.testing.assert_allclose(control[[0, 3]], [start, end], atol=1e-12)
    assert np.isfinite(control).all()


@settings(max_examples=100)
@given(start=points, v=velocities, end=points, v_s=velocities, waypoints=st.sampled_from(["clamped", "chord"]))
@example(**SLOW_TO_CONVERGE, waypoints="clamped")
def test_as_printed_t_is_that_of_the_waypoints_by_eq_4_and_5(start, v, end, v_s, waypoints):
    control, duration = trajectory(start, v, end, v_s, waypoints, AS_PRINTED)
    assert duration == pytest.approx(eq_4(control), rel=1e-12)
    assert trajectory(start, v, end, v_s, waypoints)[1] >= duration


@given(start=points, v=velocities, end=points, v_s=velocities, duration=st.floats(0.1, 3.0))
def test_handles_are_a_third_of_the_way_at_the_ends_velocity_and_at_most_0_4_of_the_chord(start, v, end, v_s, duration):
    control = clamped_waypoints(start, v, end, v_s, duration)
    limit = LONGEST_HANDLE * np.hypot(*(end - start))
    for handle, velocity in ((control[1] - control[0], v), (control[3] - control[2], v_s)):
        assert np.hypot(*handle) <= limit + 1e-12
        if np.hypot(*velocity) * duration / 3 < limit:
            np.testing.assert_allclose(handle, velocity * duration / 3, atol=1e-12)


def test_by_hand_waypoints():
    control = clamped_waypoints(ZERO, np.array([0.0, 0.6]), np.array([1.0, 0.0]), np.array([0.9, 0.0]), 1.0)
    np.testing.assert_allclose(control, [[0.0, 0.0], [0.0, 0.2], [0.7, 0.0], [1.0, 0.0]])
    even = chord_waypoints(ZERO, np.array([0.9, 0.0]))
    np.testing.assert_allclose(even, [[0.0, 0.0], [0.3, 0.0], [0.6, 0.0], [0.9, 0.0]])


def test_by_hand_from_rest_to_rest_takes_the_time_the_acceleration_asks_for():
    """0.6 m with handles of zero length: the second derivative is 6 * 0.6 m at the ends, T = sqrt(3.6 / 3) s."""
    _, duration = trajectory(ZERO, ZERO, np.array([0.6, 0.0]), ZERO)
    assert duration == pytest.approx(np.sqrt(6 * 0.6 / A_MAX))
