"""Where an impact was: the point that the ring touched and the wall's normal."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.sensing.impact_contact import impact_contact

RADIUS = 0.09


@given(st.floats(-3.1, 3.1), st.floats(0.05, 3.0), st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
@settings(derandomize=True, deadline=None, max_examples=40)
def test_without_friction_it_is_the_foot_of_the_wall(angle, strength, x, y):
    normal = np.array([math.cos(angle), math.sin(angle)])
    center = np.array([x, y])
    contact = impact_contact(7.5, center, strength * normal, RADIUS)
    assert contact.time == 7.5
    np.testing.assert_allclose(contact.normal, normal, atol=1e-12)
    np.testing.assert_allclose(contact.point, center - RADIUS * normal, atol=1e-12)


@given(st.floats(0.0, 0.6), st.booleans())
@settings(derandomize=True, deadline=None, max_examples=20)
def test_friction_turns_the_normal_by_no_more_than_its_angle(friction, left):
    change = np.array([1.0, friction if left else -friction])
    contact = impact_contact(0.0, np.zeros(2), change, RADIUS)
    assert np.hypot(*contact.normal) == pytest.approx(1.0)
    assert math.acos(min(contact.normal[0], 1.0)) == pytest.approx(math.atan(friction), abs=1e-7)


def test_a_change_of_zero_has_no_normal_and_no_error():
    contact = impact_contact(0.0, np.array([1.0, 2.0]), np.zeros(2), RADIUS)
    assert (contact.normal.tolist(), contact.point.tolist()) == ([0.0, 0.0], [1.0, 2.0])
