"""Intervals, standard deviations, improvements: worked by hand, and properties of the resampling."""

import numpy as np
import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

from collplan_study.analysis import results, statistics
from collplan_study.analysis.results import paired, samples
from collplan_study.analysis.statistics import (
    MEAN,
    MEASURES,
    SPREAD,
    Estimate,
    improvement,
    level_of,
    share,
)


@pytest.fixture(autouse=True)
def fewer_resamples(monkeypatch):
    monkeypatch.setattr(statistics, "RESAMPLES", 999)


def sample(rng, worlds, runs, mean=4.0):
    return [mean + 0.5 * rng.standard_normal() + 0.2 * rng.standard_normal(runs) for _ in range(worlds)]


def test_improvement_is_that_of_the_paper():
    ours, other = [np.array([1.0, 2.0, 3.0, 2.0, 2.0])], [np.array([2.0, 4.0, 6.0, 4.0, 4.0])]
    for measure in MEASURES:
        assert improvement(measure, ours, other).value == pytest.approx(50.0)
        assert improvement(measure, other, ours).value == pytest.approx(-100.0)


def test_mean_over_worlds_is_of_their_means_and_spread_is_within_them_or_over_worlds_of_one_run():
    runs = [np.array([1.0, 3.0]), np.array([11.0, 13.0, 12.0, 12.0])]
    assert level_of(MEAN, runs).value == pytest.approx(7.0)
    # variances 2 and 2/3
    assert level_of(SPREAD, runs).value == pytest.approx(np.sqrt((2.0 + 2.0 / 3.0) / 2.0))
    runs = [np.array([1.0]), np.array([3.0])]
    assert level_of(SPREAD, runs).value == pytest.approx(np.sqrt(2.0))


def test_what_cannot_be_known_is_said():
    for measure in MEASURES:
        assert level_of(measure, []).value is None
        few = level_of(measure, [np.array([1.0, 2.0])])
        assert (few.value is None, few.low, "2 of 5" in few.note) == (False, None, True)
        flat = level_of(measure, [np.full(20, 30.0)])
        assert (flat.low, flat.high, "no spread" in flat.note) == (None, None, True)
        runs = [np.array([3.0, 3.1, 2.9, 3.0, 3.3])]
        same = improvement(measure, runs, runs)
        assert (same.value, same.low, "equal" in same.note, same.resolved) == (0.0, None, True, False)
        assert improvement(measure, [], []).note
    one = [np.array([2.0])]
    assert (level_of(MEAN, one).value, level_of(SPREAD, one).value) == (2.0, None)
    assert improvement(SPREAD, one, [np.array([4.0])]).value is None
    assert improvement(SPREAD, [np.arange(6.0)], [np.ones(6)]).note


@settings(max_examples=15)
@given(seed=st.integers(0, 1000), copies=st.integers(2, 6))
def test_runs_that_only_repeat_their_world_make_nothing_surer(seed, copies):
    rng = np.random.default_rng(seed)
    ours, other = sample(rng, 8, 1), sample(rng, 8, 1)
    once = improvement(MEAN, ours, other)
    again = improvement(MEAN, [np.repeat(x, copies) for x in ours], [np.repeat(x, copies) for x in other])
    assert [again.value, again.low, again.high] == pytest.approx([once.value, once.low, once.high], rel=0.01)


def test_intervals_hold_the_truth_about_as_often_as_they_say():
    # 60 runs: bootstrap intervals of few runs are narrow, those of 20 hold the truth in 92 %
    rng = np.random.default_rng(1)
    n, held = 200, 0
    for _ in range(n):
        other = 4.0 + 0.4 * rng.standard_normal(60)
        found = improvement(MEAN, [0.9 * other + 0.1 * rng.standard_normal(60)], [other])
        held += found.low <= 10.0 <= found.high
    # the number of independent intervals that hold is binomial; one test in a thousand may leave this range
    fewest, most = binom.interval(0.999, n, statistics.LEVEL)
    assert fewest <= held <= most, held


def test_wilson_by_hand():
    # (p + z^2 / 2n +- z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n)
    found, z, p, n = share(15, 20), 1.959964, 0.75, 20
    centre, half = p + z**2 / (2 * n), z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    assert found.value == 75.0
    expected = 100 * (np.array([centre - half, centre + half]) / (1 + z**2 / n))
    assert [found.low, found.high] == pytest.approx(expected, abs=1e-4)
    assert share(0, 0).value is None


def test_pairs_are_what_both_have():
    schema = ["world", "trial", "value"]
    ours = pl.DataFrame([("a", 0, 1.0), ("a", 1, 2.0), ("b", 0, 3.0), ("b", 1, None)], schema, orient="row")
    other = pl.DataFrame([("a", 1, 5.0), ("a", 2, 6.0), ("c", 0, 7.0), ("b", 1, 8.0)], schema, orient="row")
    ours, other = samples(paired(ours, other))
    assert [runs.tolist() for runs in ours] == [[2.0]]
    assert [runs.tolist() for runs in other] == [[5.0]]


def test_verdicts():
    for estimate, beside_the_paper, alone in [
        (Estimate(3.0, 1.0, 5.0), results.HOLDS, results.BETTER),
        (Estimate(3.0, -1.0, 5.0), results.SAME, results.OPEN),
        (Estimate(3.0, note="few"), results.SAME, results.OPEN),
        (Estimate(-3.0, -4.0, 5.0), results.OPPOSITE, results.OPEN),
        (Estimate(-3.0, -4.0, -1.0), results.REVERSED, results.WORSE),
        (Estimate(None), results.UNKNOWN, results.UNKNOWN),
    ]:
        verdicts = [results.verdict_of(estimate, paper) for paper in (7.6, None)]
        assert verdicts == [beside_the_paper, alone], estimate
