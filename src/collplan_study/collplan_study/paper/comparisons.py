"""The paper's Table I: by how much one strategy is better than the others, beside what the paper prints."""

from dataclasses import dataclass

from collplan_study.analysis.cells import LENGTH, PANELS, TIME
from collplan_study.analysis.pairs import paired, samples
from collplan_study.analysis.statistics import MEAN, SPREAD, Estimate, improvement
from collplan_study.paper.cases import MAP_PERIOD, REFERENCE, Case

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
class WeightComparison:
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


def table_one(case: Case) -> list[WeightComparison]:
    """The improvements of a case at the paper's T_map; a strategy without runs there is taken at its smallest."""
    return [main_comparison(case, other, *panel) for other in case.others for panel in PANELS]


def main_comparison(case: Case, other: str, column: str, measure: str) -> WeightComparison:
    """One improvement of Table I."""
    return _compared(case, other, case.main_period(case.reference), case.main_period(other), column, measure)


def by_map_period(case: Case) -> list[WeightComparison]:
    """The improvements at every T_map at which both strategies have runs."""
    return [
        _compared(case, other, period, period, *panel)
        for other in case.others
        for period in case.periods(case.reference)
        if period in case.periods(other)
        for panel in PANELS
    ]


def _compared(
    case: Case, other: str, period: float, other_period: float, column: str, measure: str
) -> WeightComparison:
    """Compares the reference at a T_map [s] with another strategy at one."""
    ours = case.reference
    cell = case.runs.filter(strategy=ours, map_period_s=period)
    pairs = paired(cell, case.runs.filter(strategy=other, map_period_s=other_period), column)
    estimate = improvement(measure, *samples(pairs))
    as_paper = ours == REFERENCE and period == other_period == MAP_PERIOD
    paper = PAPER.get((other, column, measure)) if as_paper else None
    return WeightComparison(
        ours, other, period, column, measure, pairs.height, estimate, paper, verdict_of(estimate, paper)
    )


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
