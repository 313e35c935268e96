"""A LIDAR that begins to lie: the robot stands before it hits what it knew; one that is right never holds it."""

import itertools

import pytest
from lying_scans import lying_trial, world
from shifted_starts import each_shift

from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL

SENSORS = ("ideal", "low_cost")
LONG = [pytest.mark.soak, pytest.mark.timeout(7200)]


@each_shift
@pytest.mark.parametrize(("sensor", "n"), [("low_cost", 1), *(pytest.param(s, 60, marks=LONG) for s in SENSORS)])
def test_true_scans_never_hold_the_robot(sensor, n, shift):
    strategies = itertools.cycle([*TIME_TO_GOAL, *PAPER_WEIGHTS])
    for seed, strategy in zip(range(n), strategies, strict=False):
        watched = lying_trial(None, world(seed), strategy, seed, shift, **{"lidar__sensor": sensor})
        assert not watched.stood_for, (world(seed), strategy, seed)
