"""A LIDAR that begins to lie while the robot drives at 0.5 m/s or more: the robot stands before it hits what it knew.

And one that is right never holds it. `make faults` counts 30 seeds of each lie.
"""

import itertools
from functools import cache

import numpy as np
import pytest
from lying_scans import LIES, lying_trial, world
from shifted_starts import each_shift

from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL

HIT_MARGIN = 0.1
"""How much faster than in the runs without a lie a hit may be [m/s]."""
SHORT = {"trial__stuck_time": 1.0}
SENSORS = ("ideal", "low_cost")
LONG = [pytest.mark.soak, pytest.mark.timeout(7200)]


@cache
def worst_true_hit(strategy: str, seeds: range) -> float:
    """The fastest hit of the runs without a lie [m/s]."""
    return max(lying_trial(None, world(seed), strategy, seed).worst_hit for seed in seeds)


def check(name: str, strategy: str, seeds: range) -> None:
    longest = map_period_of(Settings().with_values({"planner.strategy": strategy}).planner) + 0.2
    worst = worst_true_hit(strategy, seeds)
    for seed in seeds:
        watched = lying_trial(LIES[name], world(seed), strategy, seed, **SHORT)
        assert np.isfinite(watched.begun), (name, seed)
        assert watched.stood <= longest + 1e-6, (name, seed)
        assert watched.worst_hit <= worst + HIT_MARGIN, (name, seed)


@pytest.mark.parametrize("name", ["nothing near", "frozen", "lost", "late 0.3 s unnoticed"])
def test_the_robot_stands_in_time(name):
    check(name, "avoid", range(1))


@each_shift
@pytest.mark.parametrize(("sensor", "n"), [("low_cost", 1), *(pytest.param(s, 60, marks=LONG) for s in SENSORS)])
def test_true_scans_never_hold_the_robot(sensor, n, shift):
    strategies = itertools.cycle([*TIME_TO_GOAL, *PAPER_WEIGHTS])
    for seed, strategy in zip(range(n), strategies, strict=False):
        watched = lying_trial(None, world(seed), strategy, seed, shift, **{"lidar__sensor": sensor})
        assert not watched.stood_for, (world(seed), strategy, seed)
