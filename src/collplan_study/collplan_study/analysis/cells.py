"""What the runs of one strategy at one T_map come to."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from collplan_study.analysis.comparisons import PANELS, periods_of
from collplan_study.analysis.runs import Case, Runs
from collplan_study.analysis.statistics import Estimate, level_of, share
from collplan_study.tables.rows import ERROR
from omnipuck_sim.trial import REACHED, STUCK, TIMEOUT

OUTCOMES = (REACHED, TIMEOUT, STUCK, ERROR)
MEANS = ("impacts", "deliberate_impacts", "unforeseen_impacts", "mean_speed", "candidates_mean", "plan_time_ms_p50")
LARGEST = ("max_impact_speed", "plan_time_ms_p99")


@dataclass(frozen=True)
class Cell:
    """Simulated runs of a strategy at a T_map [s].

    Attributes:
        worlds, runs: how many.
        outcomes: how often each came.
        success: share that reached the goal [%].
        levels: mean and standard deviation of arrival time [s] and path length [m], in the order of PANELS.
        means: of some columns over the runs; None without a run that has them.
        largest: of some columns.
        shares: of the control periods in each maneuver, mean over the runs.
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
    """Every cell of a case that has runs, by strategy and T_map."""
    for strategy in case.runs.distinct("strategy"):
        for period in periods_of(case, strategy):
            yield cell_of(strategy, period, case.runs)


def cell_of(strategy: str, period: float, all_runs: Runs) -> Cell:
    """The cell of a strategy at a T_map [s], out of the runs of a case."""
    runs = all_runs.where(strategy=strategy, map_period_s=period)
    found = runs.columns["outcome"].tolist()
    outcomes = {outcome: found.count(outcome) for outcome in OUTCOMES}
    shares = [name for name in runs.columns if name.startswith("share_")]
    return Cell(
        strategy, period, len(runs.distinct("world")), len(runs), outcomes, share(outcomes[REACHED], len(runs)),
        levels=tuple(level_of(measure, runs.sample(column)) for column, measure in PANELS),
        means={name: _of(runs, name, np.mean) for name in MEANS},
        largest={name: _of(runs, name, np.max) for name in LARGEST},
        shares={name.removeprefix("share_"): _of(runs, name, np.mean) for name in shares},
    )  # fmt: skip


def _of(runs: Runs, name: str, summary: Callable[..., Any]) -> float | None:
    numbers = runs.numbers(name)
    return float(summary(numbers)) if len(numbers) else None
