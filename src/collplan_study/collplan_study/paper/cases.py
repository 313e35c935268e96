"""The cases of a study of the paper's question: what one Table I is made of."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import polars as pl

from collplan_study.analysis.cells import Cell, cell_of
from collplan_study.analysis.pairs import distinct
from collplan_study.tables.columns import axes_of

REFERENCE = "harness"
MAP_PERIOD = 0.2
"""T_map of the paper's Table I [s]."""


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
        """Each T_map [s] of a strategy's runs, ascending."""
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


def cases_of(runs: pl.DataFrame) -> Iterator[Case]:
    """Every case, in the order of the table."""
    axes = axes_of(runs.columns)
    for (family, ablation, *point), rows in runs.group_by("family", "ablation", *axes, maintain_order=True):
        yield Case(str(family), str(ablation), dict(zip(axes, point, strict=True)), rows)
