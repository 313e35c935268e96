"""The fence: which polygons are one, what is outside, and who stops for it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.fence import is_outside
from collplan_core.parameters import ParameterError, Settings

QUICK = settings(derandomize=True, deadline=None, max_examples=100, print_blob=True)
SQUARE = (-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0)
ELBOW = (0.0, 0.0, 2.0, 0.0, 2.0, 2.0, 1.0, 2.0, 1.0, 1.0, 0.0, 1.0)
coordinates = st.floats(-3.0, 3.0)


@QUICK
@given(x=coordinates, y=coordinates, begin=st.integers(0, 3), backwards=st.booleans())
def test_what_is_outside_of_a_square_whichever_way_its_corners_are_given(x, y, begin, backwards):
    corners = np.roll(np.reshape(SQUARE, (-1, 2)), begin, axis=0)
    fence = tuple(corners[:: -1 if backwards else 1].ravel().tolist())
    assert is_outside(fence, np.array([x, y])) == (max(abs(x), abs(y)) > 1.0)


@QUICK
@given(x=st.floats(0.0, 2.0), y=st.floats(0.0, 2.0))
def test_a_fence_need_not_be_convex(x, y):
    assert is_outside(ELBOW, np.array([x, y])) == (x < 1.0 and y > 1.0)


@QUICK
@given(x=coordinates, y=coordinates)
def test_without_a_fence_nothing_is_outside(x, y):
    assert not is_outside((), np.array([x, y]))


@pytest.mark.parametrize(
    "fence",
    [
        (0.0,),
        (0.0, 0.0, 1.0, 0.0),
        (0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0),
        (0.0, 0.0, 1.0, 0.0, 2.0, 0.0),
        (0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0),
        (0.0, 0.0, 1.0, 0.0, 1.0, float("nan")),
        (0.0, 0.0, 1.0, 0.0, 1.0, 1e9),
    ],
)
def test_what_is_no_polygon_is_refused_with_the_value_and_what_was_expected(fence):
    with pytest.raises(ParameterError, match=r"limits\.fence: got .*, expected"):
        Settings().with_values({"limits.fence": fence})


def test_an_empty_list_in_a_file_is_no_fence():
    assert Settings().with_values({"limits.fence": []}).limits.fence == ()
