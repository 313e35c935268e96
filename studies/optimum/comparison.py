"""Strategies beside the optimum: the ratio of their arrival times to it, in each family of worlds."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from collplan_study.analysis.results import VALUE, finite, mean_over_worlds
from collplan_study.analysis.statistics import Estimate
from collplan_study.question.specification import TIME
from collplan_study.report.content import number, with_interval
from markdown_text import Section
from optimum.world_optimum import WorldOptimum


@dataclass(frozen=True)
class Ratio:
    """Times over that of the best trajectory without contact."""

    mean: Estimate  # over the worlds, of the mean over a world's runs; the interval is over the worlds
    worlds: int  # number of them
    faster: int  # number of those whose mean is below 1


@dataclass(frozen=True)
class FamilyComparison:
    """A family of worlds."""

    family: str  # its name
    time: float  # mean over the worlds of the time of the best trajectory without contact [s]
    bound: Ratio  # the lower bound, of every world one
    strategies: Mapping[str, Ratio]  # by name, in the order they were asked for


def compare(
    runs: pl.DataFrame, strategies: Sequence[str], families: Mapping[str, Sequence[WorldOptimum]]
) -> list[FamilyComparison]:
    """The runs of each strategy beside the optima of each family; worlds without a best trajectory are left out.

    `runs` are rows of the main comparison of a study; one that did not arrive counts with the time limit. `families`
    are the optima of the worlds by family.
    """
    solved = {family: [each for each in optima if each.found] for family, optima in families.items()}
    return [
        FamilyComparison(
            family=family,
            time=float(np.mean([each.time for each in optima])),
            bound=_ratio(_column(optima, lambda each: each.bound), optima),
            strategies={name: _ratio(runs.filter(strategy=name), optima) for name in strategies},
        )
        for family, optima in solved.items()
        if optima
    ]


def _column(optima: Iterable[WorldOptimum], number: Callable[[WorldOptimum], float]) -> pl.DataFrame:
    """A number of each world, as if it were the time of a run."""
    rows = [(each.world, 0, number(each)) for each in optima]
    return pl.DataFrame(rows, schema=["world", "trial", TIME], orient="row")


def _ratio(runs: pl.DataFrame, optima: Sequence[WorldOptimum]) -> Ratio:
    best = _column(optima, lambda each: each.time).select("world", best=TIME)
    ratios = runs.join(best, on="world", maintain_order="left").with_columns(
        (pl.col(TIME) / pl.col("best")).alias(VALUE)
    )
    means = finite(ratios, VALUE).group_by("world").agg(pl.col(VALUE).mean())
    return Ratio(mean_over_worlds(ratios), means.height, means.filter(pl.col(VALUE) < 1.0).height)


def record_of(comparisons: Iterable[FamilyComparison]) -> dict[str, dict[str, dict[str, Any]]]:
    """The ratios as optimum.json holds them: by family and strategy."""
    return {
        each.family: {
            name: {"ratio": ratio.mean.value, "low": ratio.mean.low, "high": ratio.mean.high, "worlds": ratio.worlds}
            for name, ratio in each.strategies.items()
        }
        for each in comparisons
    }


def table_of(comparisons: Sequence[FamilyComparison], strategies: Sequence[str]) -> Section:
    """The ratios as a table."""
    return Section(
        "Arrival time over that of the best trajectory without contact",
        "Mean over the worlds of the mean over their runs; in brackets 95 % bootstrap intervals (BCa) over the worlds; "
        "after them in how many worlds that mean is below 1. The trajectory: of a disc without noise or lag that knows "
        "the map. The bound: rest to rest over the tips along one axis, which no disc can beat that does not touch.",
        ("worlds", "number", "best [s]", "bound", *strategies),
        [
            (
                each.family,
                str(each.bound.worlds),
                number(each.time, 3),
                with_interval(each.bound.mean, 3),
                *(_cell(each.strategies[name]) for name in strategies),
            )
            for each in comparisons
        ],
    )


def _cell(ratio: Ratio) -> str:
    return f"{with_interval(ratio.mean, 3)}, {ratio.faster} of {ratio.worlds}"
