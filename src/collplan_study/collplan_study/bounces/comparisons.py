"""Gain by bounces, in pairs of runs with the same world and noise, and accuracy of the predicted rebounds."""

from dataclasses import dataclass

import numpy as np
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
    means = {"saved": VALUE, "ours_time": "ours", "other_time": "other"}
    worlds = savings(ours, other, TIME).group_by("world", maintain_order=True)
    found = worlds.agg(pl.len().alias("pairs"), *(pl.col(column).mean().alias(name) for name, column in means.items()))
    return [WorldGain(**row) for row in found.sort("saved", maintain_order=True).iter_rows(named=True)]


@dataclass(frozen=True)
class ReboundErrors:
    """Foreseen against true rebounds of a strategy's impacts (simulated); None where no impact has the number.

    Attributes:
        strategy: its name.
        impacts, speed_into: number of impacts, their mean speed into the wall [m/s].
        foreseen: number of impacts that the last plan before them foresaw; the errors below are of these.
        direction_error, direction_error_p90: angle between foreseen and true velocity after the impact [deg], median
            and 90th percentile.
        speed_error: true speed less foreseen speed after the impact [m/s], median.
        deliberate: number of foreseen impacts that were deliberate.
        deliberate_direction_error: direction error of the deliberate ones [deg], median.
    """

    strategy: str
    impacts: int
    speed_into: float | None
    foreseen: int
    direction_error: float | None
    direction_error_p90: float | None
    speed_error: float | None
    deliberate: int
    deliberate_direction_error: float | None


def rebound_errors_of(strategy: str, impacts: pl.DataFrame) -> ReboundErrors:
    """The rebound errors of a strategy, from the rows of all impacts."""
    found = impacts.filter(strategy=strategy)
    compared = found.filter(pl.col("direction_error_rad").is_finite())
    deliberate = compared.filter(deliberate=True)
    directions, speeds = _degrees(compared), (compared["measured_speed"] - compared["foreseen_speed"]).to_numpy()
    return ReboundErrors(
        strategy=strategy,
        impacts=found.height,
        speed_into=float(found["speed_into"].to_numpy().mean()) if found.height else None,
        foreseen=compared.height,
        direction_error=_percentile(directions, 50),
        direction_error_p90=_percentile(directions, 90),
        speed_error=_percentile(speeds, 50),
        deliberate=deliberate.height,
        deliberate_direction_error=_percentile(_degrees(deliberate), 50),
    )


def _degrees(impacts: pl.DataFrame) -> np.ndarray:
    return np.degrees(impacts["direction_error_rad"].to_numpy())


def _percentile(numbers: np.ndarray, percent: float) -> float | None:
    return float(np.percentile(numbers, percent)) if len(numbers) else None
