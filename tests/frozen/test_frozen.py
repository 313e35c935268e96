"""What trials, recorded runs and a study give is what it was: to the last bit, or to 1e-9 on another processor.

`make frozen` takes over a change that is meant, and says in words what has changed.
"""

import json
import math
from pathlib import Path

import pytest

import frozen_trials
from fingerprint import TOLERANCE, fingerprint, is_same
from renew import DATA, differences, frozen_parts, now_of

FROZEN = json.loads(DATA.read_text())


@pytest.mark.parametrize("part", frozen_parts())
def test_what_is_frozen_is_as_it_was(part: str, tmp_path: Path):
    assert differences(FROZEN[part], now_of(part, tmp_path)) == []


def test_every_family_and_six_strategies_are_frozen():
    assert len(frozen_trials.names()) == len(FROZEN["trials"]) == 48
    assert len(FROZEN["study"]) == 60


def test_a_fingerprint_notices_what_matters_and_allows_last_bits():
    rows = [[1.0, 2.0, math.nan], ["a", 3.0]]
    same = fingerprint(rows)
    assert is_same(same, fingerprint([[1.0 + 1e-12, 2.0, math.nan], ["a", 3.0]]))
    for other in ([[2.0, 1.0, math.nan], ["a", 3.0]], [[1.0, 2.0, math.nan], ["b", 3.0]], [[1.0, 2.0], ["a", 3.0]]):
        assert not is_same(same, fingerprint(other))
    assert not is_same(same, fingerprint([[1.0 + 1e3 * TOLERANCE, 2.0, math.nan], ["a", 3.0]]))
