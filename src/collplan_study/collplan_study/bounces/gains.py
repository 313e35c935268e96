"""Arrival time that one strategy saves against another, in pairs of runs with the same world and noise."""

from dataclasses import dataclass

import polars as pl

from collplan_study.analysis.cells import LENGTH, TIME
from collplan_study.analysis.pairs import VALUE, distinct, mean_over_worlds, savings
from collplan_study.analysis.statistics import Estimate


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
    """Gain in one world: `saved` is the mean of 100 (1 - t / t_other) [%] over its pairs; mean arrival times [s]."""

    world: str
    pairs: int
    saved: float
    ours_time: float
    other_time: float


def gain_of(runs: pl.DataFrame, ours: str, other: str) -> Gain:
    """The gain of one strategy over another, from runs at one T_map for each strategy."""
    mine, others = runs.filter(strategy=ours), runs.filter(strategy=other)
    saved = savings(mine, others, TIME)
    return Gain(
        ours=ours,
        other=other,
        worlds=len(distinct(saved, "world")),
        pairs=saved.height,
        saved=mean_over_worlds(saved),
        slower=mean_over_worlds(saved.with_columns((100.0 * (pl.col(VALUE) < 0.0)).alias(VALUE))),
        longer=mean_over_worlds(savings(mine, others, LENGTH)).negated(),
    )


def gains_by_world(ours: pl.DataFrame, other: pl.DataFrame) -> list[WorldGain]:
    """The gain in each world, ascending: where most is lost comes first."""
    worlds = savings(ours, other, TIME).partition_by("world", maintain_order=True)
    found = [
        WorldGain(pairs["world"][0], pairs.height, *(float(pairs[name].to_numpy().mean()) for name in MEANS))
        for pairs in worlds
    ]
    return sorted(found, key=lambda gain: gain.saved)


MEANS = (VALUE, "ours", "other")
