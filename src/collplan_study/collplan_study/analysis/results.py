"""table.json: what a study found, in numbers."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

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
from collplan_study.analysis.runs import Case, Runs, cases_of
from collplan_study.analysis.statistics import LEVEL, MEAN, RESAMPLES, SEED, Estimate, improvement, paired, spread_over
from collplan_study.question.ablations import SHIPPED


@dataclass(frozen=True)
class CaseResults:
    """Of a case without ablation.

    Attributes:
        worlds: their names.
        main_periods: T_map [s] of each strategy in Table I.
        spread: between what the standard deviations of its Table I are.
        table_one: at the paper's T_map; by_map_period: at every one.
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
    """Of an ablation, at the T_map of Table I.

    Attributes:
        case: name of the case that it changes.
        cells: by strategy.
        longer: mean arrival time beyond that of the same runs as shipped [%], by strategy.
        gains: improvements of mean arrival time against the other strategies.
    """

    case: str
    ablation: str
    cells: list[Cell]
    longer: list[Estimate]
    gains: list[Comparison]


@dataclass(frozen=True)
class Results:
    """Of a study."""

    cases: list[CaseResults]
    ablations: list[AblationResults]

    @property
    def comparisons(self) -> dict[str, int]:
        """How many improvements were compared, each where it stands first."""
        return {
            "table_one": sum(len(case.table_one) for case in self.cases),
            "other_map_periods": sum(len(set(case.by_map_period) - set(case.table_one)) for case in self.cases),
            "ablations": sum(len(each.gains) for each in self.ablations if each.ablation != SHIPPED),
        }

    def record(self) -> dict[str, Any]:
        """As table.json holds it."""
        return {
            "results": "simulated",
            "improvement": "100 (1 - ours / other) [%]",
            "interval": {"level": LEVEL, "method": "bootstrap, BCa, paired", "resamples": RESAMPLES, "seed": SEED},
            "resampled": "the worlds where a case has several, else its runs, in pairs of equal world and seed",
            "not_arrived": "counted with the time limit",
            "comparisons": self.comparisons,
            **asdict(self),
        }


def results_of(runs: Runs) -> Results:
    """All that is found in the rows of a study."""
    cases = list(cases_of(runs))
    shipped = [case for case in cases if not case.ablation]
    return Results([_of_case(case) for case in shipped], list(_ablations(cases)))


def _of_case(case: Case) -> CaseResults:
    mains = main_cells(case)
    return CaseResults(
        case.name, case.family, dict(case.point), case.runs.distinct("world"),
        {cell["strategy"]: cell["map_period_s"] for cell in mains},
        spread_over(case.runs.where(**mains[0]).sample(TIME)),
        table_one(case), by_map_period(case), list(cells_of(case)),
    )  # fmt: skip


def _ablations(cases: list[Case]) -> Iterator[AblationResults]:
    if not any(case.ablation for case in cases):
        return
    for shipped in cases:
        if not shipped.ablation:
            for case in cases:
                if (case.family, case.point) == (shipped.family, shipped.point):
                    yield _ablation(case, shipped)


def _ablation(case: Case, shipped: Case) -> AblationResults:
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
