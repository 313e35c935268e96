"""What the report says of one case: Table I, success and impacts, the figures and their numbers."""

from collections.abc import Iterator

from collplan_study.analysis.cells import OUTCOMES, Cell
from collplan_study.analysis.comparisons import LENGTH, PANELS, TIME, Comparison
from collplan_study.analysis.results import CaseResults
from collplan_study.analysis.statistics import MEAN, SPREAD
from collplan_study.report.figures import AXIS_LABELS
from collplan_study.report.illustrations import Illustrations
from collplan_study.report.markup import figure, heading, number, paragraph, table, with_interval
from omnipuck_sim.trial import REACHED

ROWS = {
    (TIME, MEAN): "Arrival time mean",
    (TIME, SPREAD): "Arrival time STD",
    (LENGTH, MEAN): "Path length mean",
    (LENGTH, SPREAD): "Path length STD",
}
REMARKS = {
    "corridor": (
        "This world was chosen among valid ones so that low_risk takes the detour and the others the narrow passages, "
        "as in the paper's figure: it shows the mechanism and is no independent evidence for it."
    ),
    "random": "Generated worlds, laid out for no strategy: the fairer comparison.",
}
"""By family, what must be known to read its numbers."""


def case_section(case: CaseResults, pictures: Illustrations) -> Iterator[str]:
    """The section of a case."""
    yield heading(2, f"{case.name} ({len(case.worlds)} worlds)" if len(case.worlds) > 1 else case.name)
    if case.family in REMARKS:
        yield paragraph(REMARKS[case.family])
    yield from _table_one(case)
    yield from _success(case)
    yield from _over_periods(case, pictures)
    yield from _paths(case, pictures)


def _table_one(case: CaseResults) -> Iterator[str]:
    yield heading(3, "Table I")
    if not case.table_one:
        yield paragraph("One strategy alone: nothing to compare.")
        return
    resampled = "worlds" if len(case.worlds) > 1 else "runs"
    yield paragraph(
        f"Improvement of {case.table_one[0].ours} against the others at {_periods(case)}, in percent; the {resampled} "
        f"are resampled. STD is that between {case.spread}. A run that does not arrive counts with the time limit, and "
        "with the length it drove."
    )
    head = ("Improvement [%]", "against", "simulated", "pairs", "paper", "verdict")
    yield table(head, map(_comparison_row, case.table_one))


def _periods(case: CaseResults) -> str:
    periods = set(case.main_periods.values())
    if len(periods) == 1:
        return f"T_map {periods.pop():g} s"
    return "T_map " + ", ".join(f"{period:g} s ({strategy})" for strategy, period in case.main_periods.items())


def _comparison_row(each: Comparison) -> tuple[str, ...]:
    paper = "says nothing" if each.paper is None else f"{each.paper:.2f}"
    name = ROWS[each.column, each.measure]
    return name, each.other, with_interval(each.estimate, 2), str(each.pairs), paper, each.verdict


def _success(case: CaseResults) -> Iterator[str]:
    yield heading(3, "Success")
    yield paragraph("Share of runs that arrive, with Wilson's 95 % interval, and how the others end.")
    yield table(("strategy", "runs", "arrive [%]", *OUTCOMES), map(_success_row, case.cells))
    yield heading(3, "Impacts, maneuvers, planning")
    yield paragraph(
        "Means over the runs, but the hardest impact and the slowest p99 of planning times, which are wall times of "
        "this machine at work. Deliberate: more than 0.2 m/s into the wall and foreseen by a plan. Maneuvers are "
        "shares of the time."
    )
    maneuvers = (name.replace("_", " ") for name in case.cells[0].shares)
    head = ("strategy", "impacts", "deliberate", "unforeseen", "hardest [m/s]", "mean speed [m/s]", *maneuvers,
            "candidates", "plan p99 [ms]")  # fmt: skip
    yield table(head, map(_impact_row, case.cells))


def _success_row(cell: Cell) -> tuple[str, ...]:
    outcomes = (str(cell.outcomes[outcome]) for outcome in OUTCOMES)
    return _cell_name(cell), str(cell.runs), with_interval(cell.success, 1), *outcomes


def _impact_row(cell: Cell) -> tuple[str, ...]:
    means, largest = cell.means, cell.largest
    return (
        _cell_name(cell),
        *(number(means[name], 2) for name in ("impacts", "deliberate_impacts", "unforeseen_impacts")),
        number(largest["max_impact_speed"], 2), number(means["mean_speed"], 2),
        *(number(share, 3) for share in cell.shares.values()),
        number(means["candidates_mean"], 0), number(largest["plan_time_ms_p99"], 1),
    )  # fmt: skip


def _over_periods(case: CaseResults, pictures: Illustrations) -> Iterator[str]:
    yield heading(3, "Over the mapping time T_map")
    yield figure(pictures.panels, "Mean and STD of arrival time and path length against T_map by strategy")
    yield _files(pictures.files[0])
    head = ("strategy", *(AXIS_LABELS[panel] for panel in PANELS))
    yield table(head, ((_cell_name(cell), *(with_interval(each, 3) for each in cell.levels)) for cell in case.cells))
    if len({each.map_period for each in case.by_map_period}) > 1:
        yield heading(3, "Improvement at each T_map")
        yield table(("against", *ROWS.values()), _improvements(case.by_map_period))


def _improvements(comparisons: list[Comparison]) -> Iterator[tuple[str, ...]]:
    for other, period in dict.fromkeys((each.other, each.map_period) for each in comparisons):
        row = [each.estimate for each in comparisons if (each.other, each.map_period) == (other, period)]
        yield f"{other}, {period:g} s", *(with_interval(estimate, 2) for estimate in row)


def _paths(case: CaseResults, pictures: Illustrations) -> Iterator[str]:
    yield heading(3, "Paths on the map of grown obstacles")
    shown = len({world for world, _ in pictures.drawn})
    fewest = f" in {shown} of {len(case.worlds)} worlds, those where the fewest arrive"
    some = fewest if shown < len(case.worlds) else ""
    yield paragraph(
        f"Every run{some} at {_periods(case)}; obstacles dark, grown by the robot's radius light; start a dot in the "
        "robot's outline, goal a star in its tolerance; runs that do not arrive dotted black, a cross where they end."
    )
    yield figure(pictures.paths, "Overlaid paths of each strategy")
    yield _files(pictures.files[1])
    head = ("world", "strategy", "runs", "arrive", *(AXIS_LABELS[panel] for panel in PANELS), "impacts a run")
    yield table(head, (_path_row(world, cell) for world, cell in pictures.drawn))


def _path_row(world: str, cell: Cell) -> tuple[str, ...]:
    levels = (number(level.value, 3) for level in cell.levels)
    impacts = number(cell.means["impacts"], 2)
    return world, _cell_name(cell), str(cell.runs), str(cell.outcomes[REACHED]), *levels, impacts


def _cell_name(cell: Cell) -> str:
    return f"{cell.strategy}, {cell.map_period:g} s"


def _files(stem: str) -> str:
    return paragraph(f"{stem}.png, {stem}.svg", "quiet")
