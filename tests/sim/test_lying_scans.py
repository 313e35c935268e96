"""A LIDAR that begins to lie while the robot drives at 0.5 m/s or more: the robot stands before it hits what it knew.

The long counts are 30 seeds of each lie and strategy; true scans have a file of their own.
"""

from functools import cache

import pytest
from lying_scans import LIES, watched_trial, world

from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of

HIT_MARGIN = 0.1
"""How much faster than in the runs without a lie a hit may be [m/s]."""
SHORT = {"trial.stuck_time": 1.0}


@cache
def worst_true_hit(strategy: str, seeds: range) -> float:
    """The fastest hit of the runs without a lie [m/s]."""
    return max(watched_trial(None, world(seed), strategy, seed).worst_hit for seed in seeds)


def check(name: str, strategy: str, seeds: range) -> None:
    longest = map_period_of(Settings().with_values({"planner.strategy": strategy})) + 0.2
    worst = worst_true_hit(strategy, seeds)
    for seed in seeds:
        watched = watched_trial(LIES[name], world(seed), strategy, seed, **SHORT)
        assert watched.begun == watched.begun, f"{world(seed)}, seed {seed}: never drove fast enough for a lie"
        assert watched.stood <= longest + 1e-6, f"{world(seed)}, seed {seed}: stood after {watched.stood} s"
        assert watched.worst_hit <= worst + HIT_MARGIN, f"{world(seed)}, seed {seed}: hit at {watched.worst_hit} m/s"


@pytest.mark.parametrize("name", LIES)
def test_the_robot_stands_in_time(name):
    check(name, "avoid", range(1))


@pytest.mark.soak
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("strategy", ["avoid", "stop_guarantee"])
@pytest.mark.parametrize("name", LIES)
def test_the_robot_stands_in_time_for_many_seeds(name, strategy):
    check(name, strategy, range(30))
