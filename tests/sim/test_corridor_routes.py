"""In the paper's arena risk decides the way: low risk takes the detour, high risk the narrow passages (simulated)."""

import numpy as np
import pytest

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_core.worlds import load_world
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialResult

PASSAGE_ROW = 0.65  # a height at which the first passage lies between its pillars [m]
PASSAGE = (1.02, 1.28)  # its sides there [m]


def takes_passage(run: TrialResult) -> bool:
    """Whether the run first crosses the row of the first passage through the passage."""
    crossing = np.argmax(run.trajectory[:, 2] > PASSAGE_ROW)
    return bool(PASSAGE[0] < run.trajectory[crossing, 1] < PASSAGE[1])


def runs(strategy: str, seeds: range) -> list[TrialResult]:
    settings = Settings().with_values({"planner.strategy": strategy})
    results = [run_trial(load_world("corridor"), settings, seed) for seed in seeds]
    assert [r.seed for r in results if r.outcome != REACHED] == []
    return results


@pytest.mark.parametrize("seeds", [range(5), pytest.param(range(20), marks=pytest.mark.soak)])
def test_low_risk_takes_the_detour_and_high_risk_the_passage(seeds):
    low = [takes_passage(run) for run in runs("low_risk", seeds)]
    high = [takes_passage(run) for run in runs("high_risk", seeds)]
    assert np.mean(low) <= 0.2, [s for s, passage in zip(seeds, low, strict=True) if passage]
    assert np.mean(high) >= 0.8, [s for s, passage in zip(seeds, high, strict=True) if not passage]
