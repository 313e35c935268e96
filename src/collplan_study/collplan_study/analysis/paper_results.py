"""Results of a study of the paper's question, as table.json holds them."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from collplan_study.analysis.cases import Case, cases_of
from collplan_study.analysis.cells import Cell, cell_of, cells_of
from collplan_study.analysis.comparisons import (
    TIME,
    Comparison,
    by_map_period,
    compared,
    main_cells,
    main_period,
    others_of,
    reference_of,
    table_one,
)
from collplan_study.analysis.rows import Rows
from collplan_study.analysis.statistics import LEVEL, MEAN, RESAMPLES, SEED, Estimate, improvement, paired, spread_over
from collplan_study.question.ablations import SHIPPED


@dataclass(frozen=True)
class CaseResults:
    """Results of a case without ablation.

    Attributes:
        name, family, point: name, family and point of the case.
        worlds: their names.
        main_periods: T_map [s] of each strategy in Table I.
        spread: name of the units that the standard deviations of its Table I are taken over.
        table_one: comparisons at the paper's T_map.
        by_map_period: comparisons at every T_map.
        cells: cells of every strategy and T_map.
    """

    name: str
    family: str
    point: dict[str, Any]
    worlds: list[str]
    main_periods: dict[str, float]
    spread: str
    table_one: list[Comparison]
    by_map_period: list[Comparison]
    cells: list[Cell]


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
    gains: list[Comparison]


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

    def record(self) -> dict[str, Any]:
        """The results as table.json holds them."""
        return {
            "results": "simulated",
            "improvement": "100 (1 - ours / other) [%]",
            "interval": {"level": LEVEL, "method": "bootstrap, BCa, paired", "resamples": RESAMPLES, "seed": SEED},
            "resampled": "the worlds where a case has several, else its runs, in pairs of equal world and seed",
            "not_arrived": "counted with the time limit",
            "comparisons": self.comparisons,
            **asdict(self),
        }


def paper_results_of(runs: Rows) -> PaperResults:
    """The results of a study from the rows of its runs."""
    cases = list(cases_of(runs))
    shipped = [case for case in cases if not case.ablation]
    return PaperResults([_case_results(case) for case in shipped], list(_all_ablations(cases)))


def _case_results(case: Case) -> CaseResults:
    mains = main_cells(case)
    return CaseResults(
        name=case.name,
        family=case.family,
        point=dict(case.point),
        worlds=case.runs.distinct("world"),
        main_periods={cell["strategy"]: cell["map_period_s"] for cell in mains},
        spread=spread_over(case.runs.where(**mains[0]).sample(TIME)),
        table_one=table_one(case),
        by_map_period=by_map_period(case),
        cells=list(cells_of(case)),
    )


def _all_ablations(cases: list[Case]) -> Iterator[AblationResults]:
    if not any(case.ablation for case in cases):
        return
    for shipped in cases:
        if not shipped.ablation:
            for case in cases:
                if (case.family, case.point) == (shipped.family, shipped.point):
                    yield _ablation_results(case, shipped)


def _ablation_results(case: Case, shipped: Case) -> AblationResults:
    ours = reference_of(case)
    gains = [
        compared(case.runs, ours, other, main_period(case, ours), main_period(case, other), TIME, MEAN)
        for other in others_of(case)
    ]
    cells = [cell_of(labels["strategy"], labels["map_period_s"], case.runs) for labels in main_cells(case)]
    longer = [_longer(case, shipped, labels) for labels in main_cells(case)]
    return AblationResults(shipped.name, case.ablation or SHIPPED, cells, longer, gains)


def _longer(case: Case, shipped: Case, labels: dict[str, Any]) -> Estimate:
    changed, before = (each.runs.where(**labels).by_trial(TIME) for each in (case, shipped))
    return improvement(MEAN, *paired(changed, before)).negated()
