"""Rotation and the nearest point of a segment."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point

from collplan_core.plane import nearest_on_segment, rotate, rotate_rows

# shapely cannot measure segments shorter than 1e-300
numbers = st.floats(-10.0, 10.0).map(lambda number: round(number, 9))


@settings(deadline=None)
@given(numbers, numbers, numbers)
def test_a_rotation_keeps_the_length_and_its_opposite_undoes_it(x, y, angle):
    turned = rotate(x, y, angle)
    assert math.hypot(*turned) == pytest.approx(math.hypot(x, y), abs=1e-12)
    assert rotate(*turned, -angle) == pytest.approx((x, y), abs=1e-12)


def test_x_forward_turns_into_y_left():
    assert rotate(1.0, 0.0, math.pi / 2) == pytest.approx((0.0, 1.0), abs=1e-15)


@settings(deadline=None)
@given(st.lists(st.tuples(numbers, numbers, numbers), min_size=1, max_size=8))
def test_rows_turn_like_single_vectors(rows):
    x, y, angles = np.array(rows).T
    expected = [rotate(*row) for row in rows]
    np.testing.assert_allclose(rotate_rows(np.column_stack([x, y]), angles), expected, atol=1e-12)
    np.testing.assert_allclose(rotate_rows(np.array([[1.0, 2.0]]), 0.3), [rotate(1.0, 2.0, 0.3)], atol=1e-12)


@settings(deadline=None)
@given(numbers, numbers, numbers, numbers, numbers, numbers)
def test_nothing_of_a_segment_is_nearer_than_its_nearest_point(ax, ay, bx, by, x, y):
    px, py = nearest_on_segment(ax, ay, bx, by, x, y)
    segment = LineString([(ax, ay), (bx, by)])
    assert segment.distance(Point(px, py)) < 1e-7
    assert math.hypot(px - x, py - y) == pytest.approx(segment.distance(Point(x, y)), abs=1e-7)


def test_a_segment_of_one_point_is_that_point():
    assert nearest_on_segment(1.0, 2.0, 1.0, 2.0, 5.0, 5.0) == (1.0, 2.0)
