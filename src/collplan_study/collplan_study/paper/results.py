"""Results of a study of the paper's question, as table.json holds them."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import polars as pl

from collplan_study.analysis.cells import TIME, Cell, cell_of
from collplan_study.analysis.pairs import distinct, paired, sample, samples
from collplan_study.analysis.statistics import INTERVAL, MEAN, Estimate, improvement, spread_over
from collplan_study.paper.cases import Case, WeightComparison, cases_of
from collplan_study.question.ablations import SHIPPED


@dataclass(frozen=True)
class CaseResults:
    """Results of a case without ablation.

    Attributes:
        name, family, point: those of the case.
        worlds: their names.
        main_periods: T_map [s] of each strategy in Table I.
        spread: name of the units that the standard deviations of its Table I are taken over.
        table_one, by_map_period: comparisons at the paper's T_map, and at every one.
        cells: cells of every strategy and T_map.
    """

    name: str
    family: str
    point: dict[str, Any]
    worlds: list[str]
    main_periods: dict[str, float]
    spread: str
    table_one: list[WeightComparison]
    by_map_period: list[WeightComparison]
    cells: list[Cell]

    @property
    def periods(self) -> str:
        """T_map of Table I as text."""
        periods = set(self.main_periods.values())
        if len(periods) == 1:
            return f"T_map {periods.pop():g} s"
        return "T_map " + ", ".join(f"{period:g} s ({strategy})" for strategy, period in self.main_periods.items())


@dataclass(frozen=True)
class AblationResults:
    """Results of an ablation, at the T_map of Table I.

    Attributes:
        case: name of the case without ablation.
        ablation: its name.
        cells: cells of every strategy.
        longer: mean arrival time in excess of that of the same runs without ablation [%], by strategy.
        gains: improvements of mean arrival time against the other strategies.
    """

    case: str
    ablation: str
    cells: list[Cell]
    longer: list[Estimate]
    gains: list[WeightComparison]


@dataclass(frozen=True)
class PaperResults:
    """Results of a study of the paper's question."""

    cases: list[CaseResults]
    ablations: list[AblationResults]

    @property
    def comparisons(self) -> dict[str, int]:
        """Numbers of improvements compared, by where each stands first."""
        return {
            "table_one": sum(len(case.table_one) for case in self.cases),
            "other_map_periods": sum(len(set(case.by_map_period) - set(case.table_one)) for case in self.cases),
            "ablations": sum(len(each.gains) for each in self.ablations if each.ablation != SHIPPED),
        }

    @property
    def ablations_by_case(self) -> dict[str, list[AblationResults]]:
        """The ablations by the name of their case."""
        cases = dict.fromkeys(each.case for each in self.ablations)
        return {case: [each for each in self.ablations if each.case == case] for case in cases}

    def record(self) -> dict[str, Any]:
        """The results as table.json holds them."""
        return {
            "results": "simulated",
            "improvement": "100 (1 - ours / other) [%]",
            "interval": {**INTERVAL, "method": "bootstrap, BCa, paired"},
            "resampled": "the worlds where a case has several, else its runs, in pairs of equal world and seed",
            "not_arrived": "counted with the time limit",
            "comparisons": self.comparisons,
            **asdict(self),
        }


def paper_results(runs: pl.DataFrame) -> PaperResults:
    """The results of a study from the rows of its runs."""
    cases = list(cases_of(runs))
    shipped = [case for case in cases if not case.ablation]
    ablations = _ablations(shipped, cases) if len(cases) > len(shipped) else ()
    return PaperResults([_case_results(case) for case in shipped], list(ablations))


def _case_results(case: Case) -> CaseResults:
    mains = case.main_cells
    return CaseResults(
        name=case.name,
        family=case.family,
        point=dict(case.point),
        worlds=distinct(case.runs, "world"),
        main_periods={cell["strategy"]: cell["map_period_s"] for cell in mains},
        spread=spread_over(sample(case.runs.filter(**mains[0]), TIME)),
        table_one=case.table_one(),
        by_map_period=case.by_map_period(),
        cells=list(case.cells()),
    )


def _ablations(shipped: list[Case], cases: list[Case]) -> Iterator[AblationResults]:
    for before in shipped:
        for case in (case for case in cases if (case.family, case.point) == (before.family, before.point)):
            yield AblationResults(
                case=before.name,
                ablation=case.ablation or SHIPPED,
                cells=[cell_of(case.runs, **labels) for labels in case.main_cells],
                longer=[_longer(case, before, labels) for labels in case.main_cells],
                gains=[case.compared(other, TIME, MEAN) for other in case.others],
            )


def _longer(case: Case, before: Case, labels: Mapping[str, Any]) -> Estimate:
    pairs = paired(case.runs.filter(**labels), before.runs.filter(**labels), TIME)
    return improvement(MEAN, *samples(pairs)).negated()
