"""Results of a study, as table.json holds them: its cases, their strategies, who is better, and what a change does."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import polars as pl

from collplan_core.evaluation.run_end import ABORTED, REACHED, STUCK, TIMEOUT
from collplan_study.analysis.statistics import INTERVAL, MEAN, MEASURES, SPREAD, Estimate, improvement, level_of, share
from collplan_study.question.specification import LONGER, PANELS, SAVED, SLOWER, TIME, Specification
from collplan_study.run.rows import ERROR, SHARES, axes_of, over

VALUE = "value"
"""Column of the number that a function here takes from each run, or makes of a pair of runs."""
OUTCOMES = (REACHED, TIMEOUT, STUCK, ABORTED, ERROR)
MEANS = ("impacts", "deliberate_impacts", "unforeseen_impacts", "mean_speed", "candidates_mean", "plan_time_ms_p50")
LARGEST = ("max_impact_speed", "plan_time_ms_p99")
MEANINGS = {
    MEAN: "100 (1 - ours / other) [%] of the means, as in the paper",
    SPREAD: "the same of the standard deviations",
    SAVED: "100 (1 - t / t_other) [%] of each pair of equal world and seed, mean over the worlds' means",
    SLOWER: "share of the pairs in which ours arrives later [%]",
    LONGER: "path length in excess of the other's [%], mean over the worlds' means",
}
ABOUT = {
    "results": "simulated",
    "measures": MEANINGS,
    "interval": INTERVAL,
    "resampled": "the worlds where a case has several, else its runs, in pairs of equal world and seed",
    "not_arrived": "counted with the time limit",
}
"""What table.json says of the results."""
LOSSES = (SLOWER, LONGER)
HARNESS, MAP_PERIOD = "harness", 0.2
"""The strategy that the paper judges, and T_map of its Table I [s]."""
PAPER = {"high_risk": (7.60, 3.48, 2.32, 0.99), "low_risk": (8.53, 2.39, 16.01, 0.47)}
"""Improvement of HARNESS that the paper prints [%], by strategy, in the order of PANELS. Paper: Table I."""
HOLDS, SAME, OPPOSITE, REVERSED = "holds", "same sign, open", "opposite sign, open", "reversed"
"""Verdicts beside the paper's sign: the interval has that sign; contains zero, and its value has that sign, or the
opposite one; has the opposite sign."""
BETTER, OPEN, WORSE, UNKNOWN = "better", "open", "worse", "not known"
"""Verdicts where the paper prints nothing: the interval is above zero, contains it, is below it; there is no value."""


def distinct(rows: pl.DataFrame, name: str) -> list[Any]:
    """The values of a column in the order of their first row."""
    return rows[name].unique(maintain_order=True).to_list()


def finite(rows: pl.DataFrame, column: str) -> pl.DataFrame:
    """World, trial and VALUE of the rows whose number in a column is finite."""
    return rows.select("world", "trial", pl.col(column).cast(pl.Float64).alias(VALUE)).filter(pl.col(VALUE).is_finite())


def sample(rows: pl.DataFrame, column: str = VALUE) -> list[np.ndarray]:
    """The finite numbers of a column, an array for each world."""
    worlds = finite(rows, column).group_by("world", maintain_order=True).agg(VALUE)
    return [np.array(numbers) for numbers in worlds[VALUE].to_list()]


def paired(ours: pl.DataFrame, other: pl.DataFrame, column: str = VALUE) -> pl.DataFrame:
    """World, trial and the numbers `ours` and `other` of each pair of runs of equal world and trial that has both."""
    mine, others = (finite(rows, column).rename({VALUE: name}) for rows, name in ((ours, "ours"), (other, "other")))
    return mine.join(others, on=["world", "trial"], maintain_order="left")


def samples(pairs: pl.DataFrame) -> tuple[list[np.ndarray], list[np.ndarray]]:
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


@dataclass(frozen=True)
class Cell:
    """Summary of the simulated runs of a strategy at a T_map."""

    strategy: str
    map_period: float
    worlds: int
    runs: int
    outcomes: dict[str, int]
    """Number of runs by outcome."""
    success: Estimate
    """Share of the runs that reached the goal [%]."""
    levels: tuple[Estimate, ...]
    """Mean and standard deviation of arrival time [s] and path length [m], in the order of PANELS."""
    means: dict[str, float | None]
    """Mean of each column of MEANS over the runs; None without a run that has it."""
    largest: dict[str, float | None]
    """Maximum of each column of LARGEST."""
    shares: dict[str, float | None]
    """Share of the control periods in each maneuver, mean over the runs."""
    rebounds: dict[str, float | None]
    """Of its impacts: number, mean speed into the wall [m/s]. Of those that the last plan before them foresaw: number,
    angle between foreseen and true velocity after the impact [deg], median and 90th percentile, median of true less
    foreseen speed [m/s]; number and median angle of deliberate ones. None where no impact has the number."""
    saved_by_change: Estimate | None
    """With a change: arrival time that it saves against the same runs without it [%]."""

    @property
    def name(self) -> str:
        """Strategy and T_map as text."""
        return f"{self.strategy}, {self.map_period:g} s"


@dataclass(frozen=True)
class Comparison:
    """One strategy compared with another by one measure of one column."""

    ours: str
    other: str
    map_period: float
    """T_map of ours [s]."""
    column: str
    measure: str
    worlds: int
    pairs: int
    """Of runs in the same world with the same seed."""
    estimate: Estimate
    """The number that the measure means [%]."""
    paper: float | None
    """The one that the paper prints [%], None where it prints none."""
    verdict: str
    """Whether the paper's sign holds; where it prints nothing, whether ours is better."""


@dataclass(frozen=True)
class Case:
    """Worlds that are judged together, at one point of the axes."""

    name: str
    families: tuple[str, ...]
    point: dict[str, Any]
    """Values of the axes that have several."""
    headline: bool
    """Whether no other case includes its worlds."""

    def rows(self, table: pl.DataFrame, ablation: str) -> pl.DataFrame:
        """Those of its runs, or of their impacts, with a change; its name is empty for none."""
        return table.filter(pl.col("family").is_in(self.families), ablation=ablation, **self.point)


@dataclass(frozen=True)
class CaseResults:
    """Results of a case, as shipped or with one change."""

    case: Case
    ablation: str
    """Name of the change; empty as shipped."""
    worlds: list[str]
    main_periods: dict[str, float]
    """T_map [s] at which each strategy is compared: the paper's, else its smallest. The one that is judged is first."""
    cells: list[Cell]
    """As shipped of every strategy and T_map, with a change at `main_periods`."""
    comparisons: list[Comparison]
    """The strategy that is judged against each other one."""
    by_map_period: list[Comparison]
    """The same at each T_map, where there are several, of strategies that both have runs there."""
    by_world: list[dict[str, Any]]
    """As shipped, in each world: number of pairs, time saved in their mean [%], mean arrival times [s]. The world where
    most is lost comes first."""

    @property
    def main_cells(self) -> list[Cell]:
        """The cells at `main_periods`."""
        return [cell for cell in self.cells if cell.map_period == self.main_periods[cell.strategy]]


@dataclass(frozen=True)
class StudyResults:
    """Results of a study, complete or not."""

    comparisons: dict[str, int]
    """Numbers of comparisons, without those of losses, by where each stands first."""
    cases: list[CaseResults]
    changes: list[CaseResults]


def study_results(specification: Specification, runs: pl.DataFrame, impacts: pl.DataFrame) -> StudyResults:
    """The results of a study from the rows of the runs done so far and of their impacts."""
    cases, names = list(cases_of(runs.filter(ablation=""), specification.pooled)), distinct(runs, "ablation")
    wanted = [(case, name) for case in cases for name in names if case.rows(runs, name).height]
    found = [_results(specification, case, name, runs, impacts) for case, name in wanted]
    shipped, changes = ([each for each in found if bool(each.ablation) == is_change] for is_change in (False, True))
    made = {
        "main": [one for each in shipped for one in each.comparisons],
        "other_map_periods": [one for each in shipped for one in {*each.by_map_period} - {*each.comparisons}],
        "changes": [one for each in changes for one in each.comparisons],
    }
    counts = {where: sum(one.measure not in LOSSES for one in every) for where, every in made.items()}
    return StudyResults(counts, shipped, changes)


def cases_of(runs: pl.DataFrame, pooled: Sequence[str]) -> Iterator[Case]:
    """The families of `pooled` together, where there are several, then each family at each point of the axes."""
    varied = [key for key in axes_of(runs.columns) if runs[key].n_unique() > 1]
    together = tuple(family for family in distinct(runs, "family") if family in pooled)
    if len(together) > 1:
        yield Case(f"{len(together)} families together", together, {}, headline=True)
    for row in runs.select("family", *varied).unique(maintain_order=True).iter_rows(named=True):
        family = row.pop("family")
        name = ", ".join([family, *(f"{key} = {value}" for key, value in row.items())])
        yield Case(name, (family,), row, headline=not (len(together) > 1 and family in together))


def _results(
    specification: Specification, case: Case, ablation: str, runs: pl.DataFrame, impacts: pl.DataFrame
) -> CaseResults:
    rows, shipped, hits = case.rows(runs, ablation), case.rows(runs, ""), case.rows(impacts, ablation)
    strategies: list[str] = distinct(rows, "strategy")
    ours = specification.reference if specification.reference in strategies else strategies[0]
    others = [strategy for strategy in strategies if strategy != ours]
    periods = {each: sorted(distinct(rows.filter(strategy=each), "map_period_s")) for each in (ours, *others)}
    mains = {each: MAP_PERIOD if MAP_PERIOD in found else found[0] for each, found in periods.items()}
    # what a change does is told by the first measure
    measures = (*specification.judged[: 1 if ablation else None], *specification.losses)

    def of(table: pl.DataFrame, strategy: str, period: float) -> pl.DataFrame:
        return table.filter(strategy=strategy, map_period_s=period)

    def compared(other: str, at: dict[str, float]) -> Iterator[Comparison]:
        our_runs, other_runs = (of(rows, each, at[each]) for each in (ours, other))
        is_table_one = ours == HARNESS and at[ours] == at[other] == MAP_PERIOD
        as_paper = dict(zip(PANELS, PAPER.get(other, ()), strict=False)) if is_table_one else {}
        for column, measure in measures:
            pairs, estimate = _estimate(our_runs, other_runs, column, measure)
            paper = as_paper.get((column, measure))
            verdict = "" if measure in LOSSES else verdict_of(estimate, paper)
            counts = len(distinct(pairs, "world")), pairs.height
            yield Comparison(ours, other, at[ours], column, measure, *counts, estimate, paper, verdict)

    def cell(strategy: str, period: float) -> Cell:
        found, before = of(rows, strategy, period), of(shipped, strategy, period)
        saved = _estimate(found, before, *measures[0])[1] if ablation else None
        return _cell(found, of(hits, strategy, period), saved)

    several = periods[ours] if len(periods[ours]) > 1 and not ablation else []
    at_each = [(other, period) for other in others for period in several if period in periods[other]]
    against = [each for each in (specification.against, *others) if each in others and not ablation][:1]
    pair = [of(rows, each, mains[each]) for each in (ours, *against)]
    return CaseResults(
        case=case,
        ablation=ablation,
        worlds=distinct(rows, "world"),
        main_periods=mains,
        cells=[cell(each, at) for each, found in periods.items() for at in ([mains[each]] if ablation else found)],
        comparisons=[each for other in others for each in compared(other, mains)],
        by_map_period=[each for other, at in at_each for each in compared(other, {ours: at, other: at})],
        by_world=_by_world(*pair) if against else [],
    )


def _estimate(ours: pl.DataFrame, other: pl.DataFrame, column: str, measure: str) -> tuple[pl.DataFrame, Estimate]:
    """The pairs of runs, and what a measure says of them."""
    if measure in MEASURES:
        pairs = paired(ours, other, column)
        return pairs, improvement(measure, *samples(pairs))
    pairs = savings(ours, other, column)
    if measure == SLOWER:
        pairs = pairs.with_columns((100.0 * (pl.col(VALUE) < 0.0)).alias(VALUE))
    mean = mean_over_worlds(pairs)
    return pairs, mean.negated() if measure == LONGER else mean


def verdict_of(estimate: Estimate, paper: float | None) -> str:
    """Verdict on an improvement [%], beside the one that the paper prints if it does."""
    if estimate.value is None:
        return UNKNOWN
    # all improvements that the paper prints are above zero
    words = (BETTER, OPEN, OPEN, WORSE) if paper is None else (HOLDS, SAME, OPPOSITE, REVERSED)
    if estimate.resolved:
        return words[0] if estimate.value > 0.0 else words[3]
    return words[1] if estimate.value > 0.0 else words[2]


def _by_world(ours: pl.DataFrame, other: pl.DataFrame) -> list[dict[str, Any]]:
    means = {"saved": VALUE, "ours_time": "ours", "other_time": "other"}
    worlds = savings(ours, other, TIME).group_by("world", maintain_order=True)
    found = worlds.agg(pl.len().alias("pairs"), *(pl.col(column).mean().alias(name) for name, column in means.items()))
    return found.sort("saved", maintain_order=True).rows(named=True)


def _cell(runs: pl.DataFrame, impacts: pl.DataFrame, saved_by_change: Estimate | None) -> Cell:
    outcomes = {outcome: runs.filter(outcome=outcome).height for outcome in OUTCOMES}

    def of_columns(names: Sequence[str], function: Callable[..., Any]) -> dict[str, float | None]:
        return {name.removeprefix("share_"): over(function, finite(runs, name)[VALUE].to_numpy()) for name in names}

    return Cell(
        strategy=runs["strategy"][0],
        map_period=runs["map_period_s"][0],
        worlds=len(distinct(runs, "world")),
        runs=runs.height,
        outcomes=outcomes,
        success=share(outcomes[REACHED], runs.height),
        levels=tuple(level_of(measure, sample(runs, column)) for column, measure in PANELS),
        means=of_columns(MEANS, np.mean),
        largest=of_columns(LARGEST, np.max),
        shares=of_columns(SHARES, np.mean),
        rebounds=_rebounds(impacts),
        saved_by_change=saved_by_change,
    )


def _rebounds(impacts: pl.DataFrame) -> dict[str, float | None]:
    foreseen = impacts.filter(pl.col("direction_error_rad").is_finite())
    degrees, deliberate = np.degrees(foreseen["direction_error_rad"].to_numpy()), foreseen["deliberate"].to_numpy()
    median, p90 = partial(np.percentile, q=50), partial(np.percentile, q=90)
    return {
        "impacts": impacts.height,
        "speed_into": over(np.mean, impacts["speed_into"].to_numpy()),
        "foreseen": foreseen.height,
        "direction_error": over(median, degrees),
        "direction_error_p90": over(p90, degrees),
        "speed_error": over(median, (foreseen["measured_speed"] - foreseen["foreseen_speed"]).to_numpy()),
        "deliberate": int(deliberate.sum()),
        "deliberate_direction_error": over(median, degrees[deliberate]),
    }
