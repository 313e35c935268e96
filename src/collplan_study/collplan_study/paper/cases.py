"""The cases of a study of the paper's question, and their Table I: by how much a strategy is better than others."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import polars as pl

from collplan_study.analysis.cells import LENGTH, PANELS, TIME, Cell, cell_of
from collplan_study.analysis.pairs import distinct, paired, samples
from collplan_study.analysis.statistics import MEAN, SPREAD, Estimate, improvement
from collplan_study.tables.rows import axes_of

REFERENCE = "harness"
MAP_PERIOD = 0.2
"""T_map of the paper's Table I [s]."""
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


@dataclass(frozen=True, eq=False)
class Case:
    """The runs of one family of worlds at one point of the axes and with one ablation.

    Attributes:
        family: family of the worlds.
        ablation: its name; empty without one.
        point: value of each --set axis by key.
        runs: rows of the case.
    """

    family: str
    ablation: str
    point: Mapping[str, Any]
    runs: pl.DataFrame

    @property
    def name(self) -> str:
        """Family, values of the axes and ablation as text."""
        values = [f"{key} = {value}" for key, value in self.point.items()]
        return ", ".join([self.family, *values, *([self.ablation] if self.ablation else [])])

    @property
    def reference(self) -> str:
        """The strategy that is compared with each other one: harness, else the first of the table."""
        strategies: list[str] = distinct(self.runs, "strategy")
        return REFERENCE if REFERENCE in strategies else strategies[0]

    @property
    def others(self) -> list[str]:
        """The strategies without the reference."""
        return [strategy for strategy in distinct(self.runs, "strategy") if strategy != self.reference]

    def periods(self, strategy: str) -> list[float]:
        """Values of T_map [s] in a strategy's runs, ascending."""
        return sorted(distinct(self.runs.filter(strategy=strategy), "map_period_s"))

    def main_period(self, strategy: str) -> float:
        """T_map [s] at which a strategy is compared in Table I: the paper's, else its smallest."""
        periods = self.periods(strategy)
        return MAP_PERIOD if MAP_PERIOD in periods else periods[0]

    @property
    def main_cells(self) -> list[dict[str, Any]]:
        """Strategy and map_period_s of the cells that Table I compares; the reference comes first."""
        strategies = [self.reference, *self.others]
        return [{"strategy": strategy, "map_period_s": self.main_period(strategy)} for strategy in strategies]

    def cells(self) -> Iterator[Cell]:
        """The cell of every strategy and T_map that has runs."""
        for strategy in distinct(self.runs, "strategy"):
            for period in self.periods(strategy):
                yield cell_of(self.runs, strategy, period)

    def table_one(self) -> list[WeightComparison]:
        """The improvements at the paper's T_map; a strategy without runs there is taken at its smallest."""
        return [self.compared(other, *panel) for other in self.others for panel in PANELS]

    def by_map_period(self) -> list[WeightComparison]:
        """The improvements at every T_map at which both strategies have runs."""
        return [
            self.compared(other, *panel, period)
            for other in self.others
            for period in self.periods(self.reference)
            if period in self.periods(other)
            for panel in PANELS
        ]

    def compared(self, other: str, column: str, measure: str, period: float | None = None) -> WeightComparison:
        """Compares the reference with another strategy at a T_map [s], by default that of each in Table I."""
        ours = self.reference
        periods = [self.main_period(name) if period is None else period for name in (ours, other)]
        cells = [self.runs.filter(strategy=s, map_period_s=t) for s, t in zip((ours, other), periods, strict=True)]
        pairs = paired(cells[0], cells[1], column)
        estimate = improvement(measure, *samples(pairs))
        as_paper = ours == REFERENCE and set(periods) == {MAP_PERIOD}
        paper = PAPER.get((other, column, measure)) if as_paper else None
        verdict = verdict_of(estimate, paper)
        return WeightComparison(ours, other, periods[0], column, measure, pairs.height, estimate, paper, verdict)


def cases_of(runs: pl.DataFrame) -> Iterator[Case]:
    """Every case, in the order of the table."""
    axes = axes_of(runs.columns)
    for (family, ablation, *point), rows in runs.group_by("family", "ablation", *axes, maintain_order=True):
        yield Case(str(family), str(ablation), dict(zip(axes, point, strict=True)), rows)


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
