"""People on two legs: the mean of both is the person's place, one stands while the other swings, no leg leaps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.worlds import Mover
from collplan_core.worlds.gait import TURN, discs_at, gait_of
from collplan_core.worlds.movers import HIP, PERSON, place_at

STEP = 0.002


def legs_of(mover: Mover, times: np.ndarray) -> np.ndarray:
    gait = gait_of(mover)
    return np.array([discs_at(gait, time) for time in times])


WAYS = st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=2, max_size=5)


@given(WAYS, st.floats(0.2, 1.5), st.booleans())
@settings(max_examples=40, deadline=None)
def test_one_leg_stands_while_the_other_swings_and_none_leaps(way, speed, to_and_fro):
    way = np.array([point for k, point in enumerate(way) if k == 0 or point != way[k - 1]], dtype=float)
    mover = Mover(0.06, way, speed, to_and_fro=to_and_fro, kind=PERSON)
    legs = legs_of(mover, np.arange(0.0, 6.0, STEP))
    speeds = np.hypot(*np.moveaxis(np.diff(legs, axis=0), -1, 0)) / STEP
    assert np.median(speeds.min(axis=1)) < 1e-9
    assert speeds.max() < 2.0 * speed * (1.0 + HIP * np.pi / (2.0 * TURN)) + 1e-6  # it turns by pi at most
    places = np.array([place_at(mover, time) for time in np.arange(0.0, 6.0, STEP)])
    assert np.hypot(*np.moveaxis(legs - places[:, None], -1, 0)).max() < 1.0


def test_on_a_straight_way_the_legs_are_beside_it_and_their_mean_is_the_place():
    mover = Mover(0.06, np.array([[0.0, 0.0], [9.0, 0.0]]), 1.3, to_and_fro=False, kind=PERSON)
    times = np.arange(1.0, 5.0, 0.01)
    legs = legs_of(mover, times)
    np.testing.assert_allclose(legs[:, 0, 1], HIP)
    np.testing.assert_allclose(legs[:, 1, 1], -HIP)
    np.testing.assert_allclose(legs[:, :, 0].mean(axis=1), 1.3 * times, atol=1e-9)
    assert np.ptp(legs[:, 0, 0] - legs[:, 1, 0]) == pytest.approx(1.4, rel=0.02)  # a step ahead, a step behind


def test_a_recorded_walk_is_at_its_places_at_its_times():
    times = np.array([0.0, 1.0, 4.0])
    way = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.5]])
    mover = Mover(0.06, way, 1.0, kind=PERSON, times=times)
    assert [place_at(mover, time) for time in (0.5, 1.0, 2.5, 9.0)] == [(0.5, 0.0), (1.0, 0.0), (1.0, 0.75), (1.0, 1.5)]
    with pytest.raises(ValueError, match=r"times: got \[1.0, 0.0, 2.0\], expected as many rising times"):
        Mover(0.06, way, 1.0, times=[1.0, 0.0, 2.0])
    with pytest.raises(ValueError, match="kind: got 'dog', expected one of disc, person"):
        Mover(0.06, way, 1.0, kind="dog")
