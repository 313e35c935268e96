"""The published score of the BARN challenge, for single runs and for the report's table."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from statistics import fmean
from typing import Any

OPTIMAL_SPEED = 2.0
"""Speed that the shortest path is thought to be driven at [m/s]."""

RULES = """\
Score of a run, as the BARN challenge publishes it: success x optimal time / clip(time, 2 x optimal time, 8 x optimal
time), so 0.5 is the most; optimal time: the data set's own shortest path from start to goal at 2 m/s. Start, goal, 1 m
tolerance and 100 s are the challenge's. Not so: a contact does not end a run here (the last two columns count runs
without any contact alone, as the challenge would); the robot is a disc of 0.18 m at up to 1.2 m/s instead of a Jackal
of 0.51 m by 0.43 m at 2 m/s, so that the shortest path takes it at least 1.67 x optimal time; time counts from the
first command, not from the first 0.1 m; a robot that stands still for 5 s has failed at once; the world is flat and
the pose measured, all simulated."""
"""For the default robot and rules; names what differs from the challenge's."""


@dataclass(frozen=True)
class BarnRow:
    """Runs of one strategy, all worlds together.

    Attributes:
        runs: with a known optimal length.
        success, clean_success: share that reached the goal, and did so without any contact.
        time, time_ratio: mean of those that reached the goal [s], and over the optimal time; None where none did.
        score, clean_score: mean over all runs; with contact counted as failure.
    """

    strategy: str
    map_period: float
    runs: int
    success: float
    time: float | None
    time_ratio: float | None
    score: float
    clean_success: float
    clean_score: float


def optimal_time(length: float) -> float:
    """Of a shortest path's length [m], in [s]."""
    return length / OPTIMAL_SPEED


def score(success: bool, time: float, optimal: float) -> float:
    """Of one run, its time and the optimal one [s]: 0 to 0.5, as the challenge publishes it."""
    return success * optimal / min(max(time, 2.0 * optimal), 8.0 * optimal)


def barn_rows(trials: Iterable[Mapping[str, Any]], lengths: Mapping[str, float]) -> list[BarnRow]:
    """A row for each strategy and T_map among the rows of a study's table, in their order; ablations are left out.

    Args:
        trials: with the columns of trials.parquet.
        lengths: of the shortest path by world [m]; trials in other worlds are left out.
    """
    groups: dict[tuple[str, float], list[_Run]] = defaultdict(list)
    for trial in trials:
        if trial["world"] in lengths and not trial["ablation"]:
            groups[trial["strategy"], trial["map_period_s"]].append(_run(trial, lengths[trial["world"]]))
    return [_row(strategy, period, runs) for (strategy, period), runs in groups.items()]


@dataclass(frozen=True)
class _Run:
    reached: bool
    clean: bool
    time: float
    optimal: float
    score: float


def _run(trial: Mapping[str, Any], length: float) -> _Run:
    reached, optimal = trial["outcome"] == "reached", optimal_time(length)
    # one that raised has no time and no impacts
    time = trial["arrival_time_s"] if reached else 0.0
    return _Run(reached, reached and trial["impacts"] == 0, time, optimal, score(reached, time, optimal))


def _row(strategy: str, period: float, runs: list[_Run]) -> BarnRow:
    arrived = [run for run in runs if run.reached]
    return BarnRow(
        strategy, period, len(runs),
        success=fmean(run.reached for run in runs),
        time=fmean(run.time for run in arrived) if arrived else None,
        time_ratio=fmean(run.time / run.optimal for run in arrived) if arrived else None,
        score=fmean(run.score for run in runs),
        clean_success=fmean(run.clean for run in runs),
        clean_score=fmean(run.score * run.clean for run in runs),
    )  # fmt: skip
