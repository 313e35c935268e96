"""Arrival time that one strategy saves against another, in pairs of runs with the same world and noise."""

from dataclasses import dataclass

import numpy as np

from collplan_study.analysis.comparisons import LENGTH, TIME
from collplan_study.analysis.rows import ByTrial, Rows, sample_of
from collplan_study.analysis.statistics import MEAN, Estimate, level_of


@dataclass(frozen=True)
class Gain:
    """Gain of one strategy over another; each number is the mean over the worlds of the mean over a world's pairs.

    Attributes:
        ours, other: the strategies.
        worlds, pairs: numbers of those compared.
        saved: 100 (1 - t / t_other) of the arrival times [%].
        slower: share of the pairs in which `ours` arrives later [%].
        longer: path length in excess of the other's [%].
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
    """Gain in one world.

    Attributes:
        world: its name.
        pairs: number compared.
        saved: mean of 100 (1 - t / t_other) [%].
        ours_time, other_time: mean arrival times [s].
    """

    world: str
    pairs: int
    saved: float
    ours_time: float
    other_time: float


def gain_of(runs: Rows, ours: str, other: str) -> Gain:
    """The gain of one strategy over another, from runs at one T_map for each strategy."""
    mine, others = runs.where(strategy=ours), runs.where(strategy=other)
    saved = savings(mine, others, TIME)
    slower = {world: {trial: 100.0 * (value < 0.0) for trial, value in each.items()} for world, each in saved.items()}
    return Gain(
        ours=ours,
        other=other,
        worlds=len(saved),
        pairs=sum(map(len, saved.values())),
        saved=mean_over_worlds(saved),
        slower=mean_over_worlds(slower),
        longer=mean_over_worlds(savings(mine, others, LENGTH)).negated(),
    )


def savings(ours: Rows, other: Rows, column: str) -> ByTrial:
    """100 (1 - ours / other) [%] of a column, for each pair of runs that has both numbers."""
    numbers, others = ours.by_trial(column), other.by_trial(column)
    found = {world: _saved(each, others.get(world, {})) for world, each in numbers.items()}
    return {world: each for world, each in found.items() if each}


def mean_over_worlds(numbers: ByTrial) -> Estimate:
    """Mean over the worlds of the mean over a world's trials."""
    return level_of(MEAN, sample_of(numbers))


def gains_by_world(ours: Rows, other: Rows) -> list[WorldGain]:
    """The gain in each world, ascending: where most is lost comes first."""
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
