"""By how much one strategy is faster than another, pair by pair: the same world, the same noise."""

from dataclasses import dataclass

import numpy as np

from collplan_study.analysis.comparisons import LENGTH, TIME
from collplan_study.analysis.runs import ByTrial, Runs, sample_of
from collplan_study.analysis.statistics import MEAN, Estimate, level_of


@dataclass(frozen=True)
class Gain:
    """What one strategy gains over another; means over the worlds, in each of which the mean over its pairs counts.

    Attributes:
        ours, other: the strategies.
        worlds, pairs: how many were compared.
        saved: 100 (1 - t / t_other) [%] of the arrival times of a pair.
        slower: share of the pairs in which ours arrives later [%].
        longer: path length beyond that of the other [%].
    """

    ours: str
    other: str
    worlds: int
    pairs: int
    saved: Estimate
    slower: Estimate
    longer: Estimate


@dataclass(frozen=True)
class WorldGain:
    """In one world: the mean of a pair's saving [%], and the mean arrival times [s]."""

    world: str
    pairs: int
    saved: float
    ours_time: float
    other_time: float


def gain_of(runs: Runs, ours: str, other: str) -> Gain:
    """Of one strategy against another, in runs at one T_map each."""
    mine, others = runs.where(strategy=ours), runs.where(strategy=other)
    saved = savings(mine, others, TIME)
    slower = {world: {trial: 100.0 * (value < 0.0) for trial, value in each.items()} for world, each in saved.items()}
    return Gain(
        ours, other, len(saved), sum(map(len, saved.values())),
        mean_over_worlds(saved), mean_over_worlds(slower), mean_over_worlds(savings(mine, others, LENGTH)).negated(),
    )  # fmt: skip


def savings(ours: Runs, other: Runs, column: str) -> ByTrial:
    """100 (1 - ours / other) [%] of each pair that has both numbers."""
    numbers, others = ours.by_trial(column), other.by_trial(column)
    found = {world: _saved(each, others.get(world, {})) for world, each in numbers.items()}
    return {world: each for world, each in found.items() if each}


def mean_over_worlds(numbers: ByTrial) -> Estimate:
    """The mean of the worlds' means."""
    return level_of(MEAN, sample_of(numbers))


def gains_by_world(ours: Runs, other: Runs) -> list[WorldGain]:
    """Of each world, those where ours loses most first."""
    times, other_times = ours.by_trial(TIME), other.by_trial(TIME)
    found = [
        WorldGain(world, len(each), _mean(each), _mean(times[world], each), _mean(other_times[world], each))
        for world, each in savings(ours, other, TIME).items()
    ]
    return sorted(found, key=lambda gain: gain.saved)


def _saved(ours: dict[int, float], other: dict[int, float]) -> dict[int, float]:
    # a robot that never moved has a path of no length
    return {trial: 100.0 * (1.0 - value / other[trial]) for trial, value in ours.items() if other.get(trial, 0.0) > 0.0}


def _mean(numbers: dict[int, float], trials: dict[int, float] | None = None) -> float:
    return float(np.mean([numbers[trial] for trial in trials or numbers]))
