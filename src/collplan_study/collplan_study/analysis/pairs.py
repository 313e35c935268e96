"""Numbers of runs, world by world, and those of two strategies in pairs of equal world and noise."""

from typing import Any

import numpy as np
import polars as pl

from collplan_study.analysis.statistics import MEAN, Estimate, Sample, level_of

VALUE = "value"
"""Column of the number that a function here takes from each run, or makes of a pair of runs."""


def distinct(rows: pl.DataFrame, name: str) -> list[Any]:
    """The values of a column in the order of their first row."""
    return rows[name].unique(maintain_order=True).to_list()


def finite(rows: pl.DataFrame, column: str) -> pl.DataFrame:
    """World, trial and VALUE of the rows whose number in a column is finite."""
    return rows.select("world", "trial", pl.col(column).cast(pl.Float64).alias(VALUE)).filter(pl.col(VALUE).is_finite())


def sample(rows: pl.DataFrame, column: str = VALUE) -> Sample:
    """The finite numbers of a column, an array for each world."""
    worlds = finite(rows, column).group_by("world", maintain_order=True).agg(VALUE)
    return [np.array(numbers) for numbers in worlds[VALUE].to_list()]


def paired(ours: pl.DataFrame, other: pl.DataFrame, column: str = VALUE) -> pl.DataFrame:
    """World, trial and the numbers `ours` and `other` of each pair of runs of equal world and trial that has both."""
    mine, others = (finite(rows, column).rename({VALUE: name}) for rows, name in ((ours, "ours"), (other, "other")))
    return mine.join(others, on=["world", "trial"], maintain_order="left")


def samples(pairs: pl.DataFrame) -> tuple[Sample, Sample]:
    """Both numbers of pairs as samples in the same order."""
    return sample(pairs, "ours"), sample(pairs, "other")


def savings(ours: pl.DataFrame, other: pl.DataFrame, column: str) -> pl.DataFrame:
    """World, trial and 100 (1 - ours / other) [%] as VALUE, with both numbers, of each pair."""
    # a robot that never moved has a path of no length
    pairs = paired(ours, other, column).filter(pl.col("other") > 0.0)
    return pairs.with_columns((100.0 * (1.0 - pl.col("ours") / pl.col("other"))).alias(VALUE))


def mean_over_worlds(rows: pl.DataFrame, column: str = VALUE) -> Estimate:
    """Mean over the worlds of the mean over a world's trials."""
    return level_of(MEAN, sample(rows, column))
