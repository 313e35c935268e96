"""The report's section on the worlds of BARN: success, and the score as its challenge defines it."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from collplan_core.evaluation.run_end import REACHED
from collplan_study.analysis.cases import Case
from collplan_study.analysis.cells import cell_of
from collplan_study.analysis.comparisons import TIME, main_cells
from collplan_study.analysis.rows import Rows
from collplan_study.analysis.statistics import MEAN, Estimate, level_of
from collplan_study.barn.data_set import optimal_time, score
from collplan_study.question.sources import BARN, Source
from collplan_study.report.content import Row, Table, number, with_interval
from collplan_study.report.markup import folded, section, table

RULES = (
    "Score of a run as the BARN challenge publishes it: success x optimal time / clip(time, 2 x optimal time, 8 x "
    "optimal time), at most 0.5, where the optimal time is that of the data set's own shortest path at 2 m/s; then the "
    "mean over the worlds. Start, goal, tolerance (1 m) and limit (100 s) are the challenge's. Not so: a contact does "
    "not end a run here, so runs without any are counted beside; the robot is a disc that drives 1.2 m/s at most, so "
    "that the shortest path alone takes it 1.67 x optimal time, instead of a Jackal of 0.51 m by 0.43 m at 2 m/s; time "
    "counts from the first command, not from the first 0.1 m; a robot that stands still for 5 s has failed at once; "
    "the world is flat and the pose measured. Times are means of the runs that arrive."
)


def barn_section(case: Case, sources: Sequence[Source]) -> Iterator[str]:
    """The section of a case; empty if its worlds are not BARN's."""
    if case.family != BARN:
        return
    lengths = {each.world.name: each.optimal_length for each in sources if each.optimal_length is not None}
    times = ("time [s]", "time / optimal")
    head = ("strategy", "runs", "arrive [%]", *times, "score", "arrive untouched [%]", "score of untouched runs")
    rows = [_row(case, cell, lengths) for cell in main_cells(case)]
    yield from section(3, Table("BARN's score", RULES, head, rows))
    strategies = (cell["strategy"] for cell in main_cells(case))
    yield folded("World by world", table(("world", "shortest [m]", *strategies), _worlds(case, lengths)))


def _mean_score(runs: Rows, lengths: Mapping[str, float], touching_fails: bool = False) -> Estimate:
    """Mean score over the worlds in `lengths`, which holds the length of each world's shortest path [m]."""
    scores: dict[str, list[float]] = {}
    for row in runs.dicts("world", "outcome", TIME, "impacts"):
        if row["world"] in lengths:
            success = row["outcome"] == REACHED and not (touching_fails and row["impacts"])
            # a run that raised has no time
            value = score(success, row[TIME], optimal_time(lengths[row["world"]])) if success else 0.0
            scores.setdefault(row["world"], []).append(value)
    return level_of(MEAN, [np.array(each) for each in scores.values()])


def _time_ratio(runs: Rows, lengths: Mapping[str, float]) -> Estimate:
    """Arrival time over optimal time in the worlds in `lengths`, which holds the length of each shortest path [m]."""
    times = {world: np.array(list(found.values())) for world, found in runs.by_trial(TIME).items() if world in lengths}
    return level_of(MEAN, [found / optimal_time(lengths[world]) for world, found in times.items()])


def _row(case: Case, labels: Mapping[str, Any], lengths: Mapping[str, float]) -> Row:
    runs = case.runs.where(**labels)
    cell = cell_of(labels["strategy"], labels["map_period_s"], case.runs)
    arrived = runs.where(outcome=REACHED)
    untouched = arrived.where(impacts=0)
    return (
        f"{cell.strategy}, {cell.map_period:g} s",
        str(cell.runs),
        with_interval(cell.success, 1),
        with_interval(level_of(MEAN, arrived.sample(TIME)), 2),
        with_interval(_time_ratio(arrived, lengths), 2),
        with_interval(_mean_score(runs, lengths), 3),
        number(100.0 * len(untouched) / len(runs), 1),
        with_interval(_mean_score(runs, lengths, touching_fails=True), 3),
    )


def _worlds(case: Case, lengths: Mapping[str, float]) -> Iterator[Row]:
    for world in case.runs.distinct("world"):
        found = (_runs_in(case.runs.where(world=world, **cell)) for cell in main_cells(case))
        yield world, number(lengths.get(world), 2), *found


def _runs_in(runs: Rows) -> str:
    rows = runs.dicts("outcome", TIME, "impacts")
    return "\n".join("{}, {:.1f} s, {:.0f} impacts".format(*row.values()) for row in rows)
