"""The paper's Table I: by how much one strategy is better than the others, beside what the paper prints."""

from dataclasses import dataclass
from typing import Any

from collplan_study.analysis.cases import Case
from collplan_study.analysis.rows import Rows
from collplan_study.analysis.statistics import MEAN, MEASURES, SPREAD, Estimate, improvement, paired

REFERENCE = "harness"
MAP_PERIOD = 0.2
"""T_map of the paper's Table I [s]."""
TIME, LENGTH = "arrival_time_s", "path_length_m"
PANELS = tuple((column, measure) for column in (TIME, LENGTH) for measure in MEASURES)
"""Column and statistic of each row of Table I, and of each panel of the paper's figure over T_map."""
PAPER = {
    ("high_risk", TIME, MEAN): 7.60,
    ("high_risk", TIME, SPREAD): 3.48,
    ("high_risk", LENGTH, MEAN): 2.32,
    ("high_risk", LENGTH, SPREAD): 0.99,
    ("low_risk", TIME, MEAN): 8.53,
    ("low_risk", TIME, SPREAD): 2.39,
    ("low_risk", LENGTH, MEAN): 16.01,
    ("low_risk", LENGTH, SPREAD): 0.47,
}
"""Improvement that the paper prints [%], by strategy, column and statistic. Paper: Table I."""

HOLDS, SAME, OPPOSITE, REVERSED = "holds", "same sign, open", "opposite sign, open", "reversed"
"""Verdicts beside the paper's sign: the interval has that sign; contains zero, and its value has that sign, or the
opposite one; has the opposite sign."""
BETTER, OPEN, WORSE = "better", "open", "worse"
"""Verdicts where the paper prints nothing: the interval is above zero, contains it, is below it."""
UNKNOWN = "not known"


@dataclass(frozen=True)
class Comparison:
    """One strategy compared with another by one statistic.

    Attributes:
        ours, other: the strategies.
        map_period: T_map of ours [s].
        column, measure: the column compared, and whether by mean or standard deviation.
        pairs: number of pairs of runs in the same world with the same seed.
        estimate: the improvement 100 (1 - ours / other) [%].
        paper: the improvement that the paper prints [%], None where it prints none.
        verdict: whether the paper's sign holds; where it prints nothing, whether ours is better.
    """

    ours: str
    other: str
    map_period: float
    column: str
    measure: str
    pairs: int
    estimate: Estimate
    paper: float | None
    verdict: str


def table_one(case: Case) -> list[Comparison]:
    """The improvements of a case at the paper's T_map; a strategy without runs there is taken at its smallest."""
    ours = reference_of(case)
    return [
        compared(case.runs, ours, other, main_period(case, ours), main_period(case, other), column, measure)
        for other in others_of(case)
        for column, measure in PANELS
    ]


def by_map_period(case: Case) -> list[Comparison]:
    """The improvements at every T_map at which both strategies have runs."""
    ours = reference_of(case)
    return [
        compared(case.runs, ours, other, period, period, column, measure)
        for other in others_of(case)
        for period in periods_of(case, ours)
        if period in periods_of(case, other)
        for column, measure in PANELS
    ]


def reference_of(case: Case) -> str:
    """The strategy that is compared with each other one: harness, else the first of the table."""
    strategies: list[str] = case.runs.distinct("strategy")
    return REFERENCE if REFERENCE in strategies else strategies[0]


def others_of(case: Case) -> list[str]:
    """The strategies of a case without its reference."""
    return [strategy for strategy in case.runs.distinct("strategy") if strategy != reference_of(case)]


def periods_of(case: Case, strategy: str) -> list[float]:
    """Each T_map [s] of a strategy's runs, ascending."""
    return sorted(case.runs.where(strategy=strategy).distinct("map_period_s"))


def main_period(case: Case, strategy: str) -> float:
    """T_map [s] at which a strategy is compared in Table I."""
    periods = periods_of(case, strategy)
    return MAP_PERIOD if MAP_PERIOD in periods else periods[0]


def main_cells(case: Case) -> list[dict[str, Any]]:
    """Strategy and map_period_s of the cells that Table I compares; the reference comes first."""
    strategies = [reference_of(case), *others_of(case)]
    return [{"strategy": strategy, "map_period_s": main_period(case, strategy)} for strategy in strategies]


def compared(
    runs: Rows, ours: str, other: str, period: float, other_period: float, column: str, measure: str
) -> Comparison:
    """Compares two strategies by one statistic.

    Args:
        runs: runs of a case.
        ours, other: the strategies.
        period, other_period: T_map of each [s].
        column, measure: as in `Comparison`.
    """
    cell = runs.where(strategy=ours, map_period_s=period)
    other_cell = runs.where(strategy=other, map_period_s=other_period)
    samples = paired(cell.by_trial(column), other_cell.by_trial(column))
    estimate = improvement(measure, *samples)
    as_paper = ours == REFERENCE and period == other_period == MAP_PERIOD
    paper = PAPER.get((other, column, measure)) if as_paper else None
    pairs = sum(map(len, samples[0]))
    return Comparison(ours, other, period, column, measure, pairs, estimate, paper, verdict_of(estimate, paper))


def verdict_of(estimate: Estimate, paper: float | None) -> str:
    """Verdict on an improvement [%], beside the one that the paper prints if it does."""
    if estimate.value is None:
        return UNKNOWN
    better = estimate.value > 0.0
    if paper is None:
        return (BETTER if better else WORSE) if estimate.resolved else OPEN
    # all improvements that the paper prints are above zero
    if estimate.resolved:
        return HOLDS if better else REVERSED
    return SAME if better else OPPOSITE
