"""A LIDAR that begins to lie while the robot drives at 0.5 m/s or more: the robot stands before it hits what it knew.

The long counts are 30 seeds of each lie and strategy, and 300 runs without a lie for each sensor.
"""

import itertools

import pytest
from lying_scans import LIES, watched_trial

from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL

FAMILIES = ("corridor", "random", "serpentine", "u", "l", "z", "baffles", "pillars")
HIT_MARGIN = 0.1
"""How much faster than in the runs without a lie a hit may be [m/s]."""
SHORT = {"trial.stuck_time": 1.0}


def world(seed: int) -> str:
    family = FAMILIES[seed % len(FAMILIES)]
    return family if family == "corridor" else f"{family}:{seed}"


def check(name: str, strategy: str, seeds: range) -> None:
    longest = map_period_of(Settings().with_values({"planner.strategy": strategy})) + 0.2
    worst = max(watched_trial(None, world(seed), strategy, seed).worst_hit for seed in seeds)
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


def check_clean(sensor: str, n: int) -> None:
    strategies = itertools.cycle([*TIME_TO_GOAL, *PAPER_WEIGHTS])
    for seed, strategy in zip(range(n), strategies, strict=False):
        watched = watched_trial(None, world(seed), strategy, seed, **{"lidar.sensor": sensor})
        assert not watched.held, f"{world(seed)}, {strategy}, seed {seed}: {watched.held[0]}"


@pytest.mark.parametrize("sensor", ["ideal", "low_cost"])
def test_true_scans_never_hold_the_robot(sensor):
    check_clean(sensor, 2)


@pytest.mark.soak
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("sensor", ["ideal", "low_cost"])
def test_true_scans_never_hold_the_robot_in_300_runs(sensor):
    check_clean(sensor, 300)
