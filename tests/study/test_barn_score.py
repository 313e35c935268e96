import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_study.barn.data_set import optimal_time, score

times = st.floats(0.01, 1000.0)


@pytest.mark.parametrize(
    ("success", "time", "expected"),
    [
        (True, 5.0, 0.5),
        (True, 10.0, 0.5),
        (True, 20.0, 0.25),
        (True, 40.0, 0.125),
        (True, 99.0, 0.125),
        (False, 5.0, 0),
    ],
)
def test_score_by_hand(success, time, expected):
    assert score(success, time, optimal_time(10.0)) == pytest.approx(expected)


@settings(derandomize=True, deadline=None, max_examples=50)
@given(time=times, later=times, optimal=times)
def test_score_is_bounded_and_never_better_for_being_later(time, later, optimal):
    first, second = (score(True, t, optimal) for t in sorted((time, later)))
    assert 0.125 <= second <= first <= 0.5
    assert first == pytest.approx(np.clip(optimal / min(time, later), 0.125, 0.5))
