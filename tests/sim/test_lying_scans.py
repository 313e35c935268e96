"""A LIDAR that begins to lie while the robot drives at 0.5 m/s or more: the robot stands before it hits what it knew.

And one that is right never holds it. `make faults` counts 30 seeds of each lie.
"""

import itertools

import numpy as np
import pytest
from lying_scans import LIES, lying_trial, world
from shifted_starts import each_shift

from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL

HIT_MARGIN = 0.1
"""How much faster than in the runs without a lie a hit may be [m/s]."""
SENSORS = ("ideal", "low_cost")
LONG = [pytest.mark.soak, pytest.mark.timeout(7200)]


def test_the_robot_stands_in_time():
    longest = map_period_of(Settings().with_values({"planner.strategy": "avoid"}).planner) + 0.2
    watched = lying_trial(LIES["late 0.3 s unnoticed"], world(0), "avoid", 0, trial__stuck_time=1.0)
    assert np.isfinite(watched.begun)
    assert watched.stood <= longest + 1e-6
    assert watched.worst_hit <= lying_trial(None, world(0), "avoid", 0).worst_hit + HIT_MARGIN


@each_shift
@pytest.mark.parametrize(("sensor", "n"), [("low_cost", 1), *(pytest.param(s, 60, marks=LONG) for s in SENSORS)])
def test_true_scans_never_hold_the_robot(sensor, n, shift):
    strategies = itertools.cycle([*TIME_TO_GOAL, *PAPER_WEIGHTS])
    for seed, strategy in zip(range(n), strategies, strict=False):
        watched = lying_trial(None, world(seed), strategy, seed, shift, **{"lidar__sensor": sensor})
        assert not watched.stood_for, (world(seed), strategy, seed)
