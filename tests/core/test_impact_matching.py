"""Impacts of a run against the contacts its plans foresaw."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.evaluation.impact_matching import NOTICE, UNMATCHED, Prediction, foreseen_impacts, match_contacts
from collplan_core.plan import Contacts


def contacts(*rows):
    table = np.array(rows, dtype=float).reshape(-1, 3)
    return Contacts(table[:, 0], table[:, 1:], np.zeros((len(table), 2)))


def foreseen(impacts, *predictions):
    table = np.array(impacts, dtype=float).reshape(-1, 3)
    return foreseen_impacts(table[:, 0], table[:, 1:], [Prediction(made, c) for made, c in predictions]).tolist()


HIT = (1.0, 0.5, 0.0)


@pytest.mark.parametrize(
    ("predictions", "expected"),
    [
        ([], False),
        ([(0.5, contacts(HIT))], True),
        ([(0.86, contacts(HIT))], False),  # too late to be a forecast
        ([(0.5, contacts((1.14, 0.5, 0.07)))], True),
        ([(0.5, contacts((1.16, 0.5, 0.0)))], False),
        ([(0.5, contacts((1.0, 0.5, 0.09)))], False),
        ([(0.5, contacts(HIT)), (0.7, contacts())], False),  # the successor gave it up
        ([(0.5, contacts(HIT)), (0.7, contacts((1.05, 0.52, 0.0)))], True),
        ([(0.5, contacts(HIT)), (0.9, contacts())], False),  # given up at the last moment
        ([(0.5, contacts(HIT)), (0.9, contacts(HIT))], True),  # confirmed at the last moment
        ([(0.5, contacts()), (0.9, contacts(HIT))], False),
        ([(0.5, contacts(HIT)), (1.01, contacts())], True),  # made after the impact, says nothing about it
    ],
)
def test_an_impact_is_foreseen_by_a_plan_still_in_force(predictions, expected):
    assert foreseen([HIT], *predictions) == [expected]


def test_one_contact_stands_for_one_impact():
    twice = [HIT, (1.1, 0.5, 0.02)]
    assert foreseen(twice, (0.5, contacts(HIT))) == [True, False]
    assert foreseen(twice, (0.5, contacts(HIT, (1.12, 0.5, 0.0)))) == [True, True]


times = st.lists(st.floats(0.0, 5.0), max_size=6)
places = st.floats(-0.3, 0.3)
hits = st.tuples(st.floats(0.0, 2.0), places, places)


@given(st.lists(hits, max_size=6), st.lists(hits, max_size=6))
@settings(derandomize=True, deadline=None, max_examples=60)
def test_pairs_are_within_tolerance_and_used_once(impacts, predicted):
    table = np.array(impacts, dtype=float).reshape(-1, 3)
    made = contacts(*predicted)
    matched = match_contacts(table[:, 0], table[:, 1:], made)
    used = matched[matched != UNMATCHED]
    assert len(set(used)) == len(used)
    for i in np.flatnonzero(matched != UNMATCHED):
        assert abs(table[i, 0] - made.times[matched[i]]) <= 0.15
        assert np.linalg.norm(table[i, 1:] - made.points[matched[i]]) <= 0.08
    left = [i for i in range(len(table)) if matched[i] == UNMATCHED]
    free = [j for j in range(len(made.times)) if j not in used]
    for i in left:
        for j in free:
            assert abs(table[i, 0] - made.times[j]) > 0.15 or np.linalg.norm(table[i, 1:] - made.points[j]) > 0.08


@given(st.lists(hits, min_size=1, max_size=5), times)
@settings(derandomize=True, deadline=None, max_examples=60)
def test_plans_that_all_foretell_exactly_leave_only_short_notice(impacts, made):
    table = sorted(set(impacts))
    exact = contacts(*table)
    result = foreseen(table, *[(m, exact) for m in sorted(made)])
    assert result == [any(m <= t - NOTICE for m in made) for t, _, _ in table]
