"""Summaries of the runs of one strategy at one T_map."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from collplan_core.evaluation.run_end import ABORTED, REACHED, STUCK, TIMEOUT
from collplan_study.analysis.cases import Case
from collplan_study.analysis.comparisons import PANELS, periods_of
from collplan_study.analysis.rows import Rows
from collplan_study.analysis.statistics import Estimate, level_of, share
from collplan_study.tables.trial_record import ERROR

OUTCOMES = (REACHED, TIMEOUT, STUCK, ABORTED, ERROR)
MEANS = ("impacts", "deliberate_impacts", "unforeseen_impacts", "mean_speed", "candidates_mean", "plan_time_ms_p50")
LARGEST = ("max_impact_speed", "plan_time_ms_p99")


@dataclass(frozen=True)
class Cell:
    """Summary of the simulated runs of a strategy at a T_map.

    Attributes:
        strategy: its name.
        map_period: T_map [s].
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


def cells_of(case: Case) -> Iterator[Cell]:
    """Every cell of a case that has runs, ordered by strategy and T_map."""
    for strategy in case.runs.distinct("strategy"):
        for period in periods_of(case, strategy):
            yield cell_of(strategy, period, case.runs)


def cell_of(strategy: str, period: float, all_runs: Rows) -> Cell:
    """The cell of a strategy at a T_map [s], from the runs of a case."""
    runs = all_runs.where(strategy=strategy, map_period_s=period)
    found = runs.columns["outcome"].tolist()
    outcomes = {outcome: found.count(outcome) for outcome in OUTCOMES}
    shares = [name for name in runs.columns if name.startswith("share_")]
    return Cell(
        strategy=strategy,
        map_period=period,
        worlds=len(runs.distinct("world")),
        runs=len(runs),
        outcomes=outcomes,
        success=share(outcomes[REACHED], len(runs)),
        levels=tuple(level_of(measure, runs.sample(column)) for column, measure in PANELS),
        means={name: _summary(runs, name, np.mean) for name in MEANS},
        largest={name: _summary(runs, name, np.max) for name in LARGEST},
        shares={name.removeprefix("share_"): _summary(runs, name, np.mean) for name in shares},
    )


def _summary(runs: Rows, name: str, function: Callable[..., Any]) -> float | None:
    numbers = runs.numbers(name)
    return float(function(numbers)) if len(numbers) else None
