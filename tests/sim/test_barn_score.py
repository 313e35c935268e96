import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omnipuck_sim.study.barn_score import BarnRow, barn_rows, optimal_time, score

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


def trial(world, strategy, outcome, time, impacts=0, ablation=""):
    return {
        "world": world, "strategy": strategy, "map_period_s": 0.2, "ablation": ablation, "outcome": outcome,
        "arrival_time_s": time, "impacts": impacts,
    }  # fmt: skip


def test_table_by_hand():
    trials = [
        trial("barn:3", "harness", "reached", 10.0),
        trial("barn:9", "harness", "reached", 20.0, impacts=2),
        trial("barn:3", "harness", "stuck", 100.0),
        trial("barn:3", "harness", "error", None, impacts=None),
        trial("barn:3", "high_risk", "timeout", 100.0, impacts=9),
        trial("barn:3", "harness", "reached", 1.0, ablation="no_pruning"),
        trial("corridor", "harness", "reached", 1.0),
    ]
    assert barn_rows(trials, {"barn:3": 10.0, "barn:9": 8.0}) == [
        # optimal 5 s and 4 s: scores 0.5 and 4 / 20 of four runs
        BarnRow("harness", 0.2, 4, 0.5, 15.0, pytest.approx(3.5), pytest.approx(0.175), 0.25, 0.125),
        BarnRow("high_risk", 0.2, 1, 0.0, None, None, 0.0, 0.0, 0.0),
    ]
    assert barn_rows(trials, {}) == []
