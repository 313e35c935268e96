"""A LIDAR that tells the truth never holds the robot: 300 runs for each sensor are the long count."""

import itertools

import pytest
from lying_scans import watched_trial, world

from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL


def check(sensor: str, n: int) -> None:
    strategies = itertools.cycle([*TIME_TO_GOAL, *PAPER_WEIGHTS])
    for seed, strategy in zip(range(n), strategies, strict=False):
        watched = watched_trial(None, world(seed), strategy, seed, **{"lidar.sensor": sensor})
        assert not watched.held, f"{world(seed)}, {strategy}, seed {seed}: {watched.held[0]}"


@pytest.mark.parametrize("sensor", ["ideal", "low_cost"])
def test_true_scans_never_hold_the_robot(sensor):
    check(sensor, 2)


@pytest.mark.soak
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("sensor", ["ideal", "low_cost"])
def test_true_scans_never_hold_the_robot_in_300_runs(sensor):
    check(sensor, 300)
