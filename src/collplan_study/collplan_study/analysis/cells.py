"""Summaries of the runs of one strategy at one T_map."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from collplan_core.evaluation.run_end import ABORTED, REACHED, STUCK, TIMEOUT
from collplan_study.analysis.pairs import VALUE, distinct, finite, sample
from collplan_study.analysis.statistics import MEASURES, Estimate, level_of, share
from collplan_study.tables.rows import ERROR, SHARES

TIME, LENGTH = "arrival_time_s", "path_length_m"
PANELS = tuple((column, measure) for column in (TIME, LENGTH) for measure in MEASURES)
"""Column and statistic of each row of the paper's Table I, and of each panel of its figure over T_map."""
OUTCOMES = (REACHED, TIMEOUT, STUCK, ABORTED, ERROR)
MEANS = ("impacts", "deliberate_impacts", "unforeseen_impacts", "mean_speed", "candidates_mean", "plan_time_ms_p50")
LARGEST = ("max_impact_speed", "plan_time_ms_p99")


@dataclass(frozen=True)
class Cell:
    """Summary of the simulated runs of a strategy at a T_map.

    Attributes:
        strategy, map_period: its name, T_map [s].
        worlds, runs: their numbers.
        outcomes: number of runs by outcome.
        success: share of the runs that reached the goal [%].
        levels: mean and standard deviation of arrival time [s] and path length [m], in the order of PANELS.
        means: mean of each column of MEANS over the runs; None without a run that has it.
        largest: maximum of each column of LARGEST; None without a run that has it.
        shares: share of the control periods in each maneuver, mean over the runs.
    """

    strategy: str
    map_period: float
    worlds: int
    runs: int
    outcomes: dict[str, int]
    success: Estimate
    levels: tuple[Estimate, ...]
    means: dict[str, float | None]
    largest: dict[str, float | None]
    shares: dict[str, float | None]

    @property
    def name(self) -> str:
        """Strategy and T_map as text."""
        return f"{self.strategy}, {self.map_period:g} s"

    @property
    def other_ends(self) -> str:
        """Ends of the runs that do not arrive, as text."""
        ends = (f"{count} {end}" for end, count in self.outcomes.items() if count and end != REACHED)
        return ", ".join(ends) or "none"


def cell_of(all_runs: pl.DataFrame, strategy: str, map_period_s: float) -> Cell:
    """The cell of a strategy at a T_map [s], from runs that differ in nothing else."""
    runs = all_runs.filter(strategy=strategy, map_period_s=map_period_s)
    outcomes = {outcome: runs.filter(outcome=outcome).height for outcome in OUTCOMES}
    return Cell(
        strategy=strategy,
        map_period=map_period_s,
        worlds=len(distinct(runs, "world")),
        runs=runs.height,
        outcomes=outcomes,
        success=share(outcomes[REACHED], runs.height),
        levels=tuple(level_of(measure, sample(runs, column)) for column, measure in PANELS),
        means={name: _summary(runs, name, np.mean) for name in MEANS},
        largest={name: _summary(runs, name, np.max) for name in LARGEST},
        shares={name.removeprefix("share_"): _summary(runs, name, np.mean) for name in SHARES},
    )


def _summary(runs: pl.DataFrame, name: str, function: Callable[..., Any]) -> float | None:
    numbers = finite(runs, name)[VALUE].to_numpy()
    return float(function(numbers)) if len(numbers) else None
