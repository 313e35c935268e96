"""What the last plan before each impact foresaw of its rebound."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.evaluation.impact_matching import Prediction, foreseen_rebounds
from collplan_core.plan import Contacts
from scenes import rotation, unit

QUICK = settings(derandomize=True, deadline=None, max_examples=60, print_blob=True)
HIT = (1.0, 0.5, 0.0, -0.7, 0.2)
"""Time, point, velocity after."""


def contacts(*rows) -> Contacts:
    table = np.array(rows, dtype=float).reshape(-1, 5)
    return Contacts(table[:, 0], table[:, 1:3], table[:, 3:])


def compared(impacts, *predictions) -> np.ndarray:
    table = np.array(impacts, dtype=float).reshape(-1, 5)
    made = [Prediction(when, contacts(*rows)) for when, *rows in predictions]
    return foreseen_rebounds(table[:, 0], table[:, 1:3], table[:, 3:], made)


def test_without_impacts_or_plans_there_is_nothing_to_tell():
    assert compared([]).shape == (0, 3)
    assert compared([], (0.5, HIT)).shape == (0, 3)
    assert np.isnan(compared([HIT])).all()
    assert compared([HIT, HIT]).shape == (2, 3)


def test_by_hand_a_rebound_slower_and_turned():
    came = 0.5 * rotation(0.3) @ np.array([-0.7, 0.2])
    (row,) = compared([(1.02, 0.51, 0.03, *came)], (0.9, HIT))
    np.testing.assert_allclose(row, (0.3, np.hypot(0.7, 0.2), 0.5 * np.hypot(0.7, 0.2)))


@pytest.mark.parametrize(
    ("predictions", "told"),
    [
        ([(0.5, HIT), (0.9, HIT)], True),
        ([(0.5, HIT), (0.9,)], False),  # the last plan gave it up
        ([(0.5,), (0.99, HIT)], True),  # the last plan alone counts
        ([(1.1, HIT)], False),  # made after it
        ([(0.5, (1.2, *HIT[1:]))], False),  # foreseen for another time
        ([(0.5, (1.0, 0.6, 0.0, -0.7, 0.2))], False),  # elsewhere
        ([(0.5, (3.0, 0.5, 0.0, 1.0, 0.0), HIT)], True),
    ],
)
def test_the_last_plan_before_an_impact_is_asked(predictions, told):
    row = compared([HIT], *predictions)[0]
    if told:
        np.testing.assert_allclose(row, (0.0, np.hypot(0.7, 0.2), np.hypot(0.7, 0.2)), atol=1e-12)
    else:
        assert np.isnan(row).all()


def test_of_two_impacts_each_has_its_own():
    second = (1.6, 0.1, 0.4, 0.3, 0.3)
    rows = compared([HIT, second], (0.5, HIT, second))
    np.testing.assert_allclose(rows[:, 0], 0.0, atol=1e-12)
    np.testing.assert_allclose(rows[:, 1], (np.hypot(0.7, 0.2), np.hypot(0.3, 0.3)))
    assert np.isnan(compared([HIT, second], (0.5, HIT))).tolist() == [[False] * 3, [True] * 3]


@QUICK
@given(angle=st.floats(-np.pi, np.pi), turn=st.floats(-np.pi, np.pi), speed=st.floats(0.01, 2.0))
def test_the_angle_is_that_between_them_whatever_way_both_point(angle, turn, speed):
    foreseen, came = unit(angle), speed * unit(angle + turn)
    row = compared([(1.0, 0.5, 0.0, *came)], (0.5, (1.0, 0.5, 0.0, *foreseen)))[0]
    np.testing.assert_allclose(row, (abs(turn), 1.0, speed), atol=1e-6)


def test_a_robot_that_stayed_where_it_hit_has_no_direction_but_a_speed():
    row = compared([(1.0, 0.5, 0.0, 0.0, 0.0)], (0.5, HIT))[0]
    assert np.isfinite(row).all()
    assert row[2] == 0.0
