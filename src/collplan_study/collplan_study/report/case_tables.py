"""The tables of one case: Table I, success and impacts, the numbers of the pictures."""

from collections.abc import Iterator

from collplan_core.evaluation.run_end import REACHED
from collplan_study.analysis.cells import OUTCOMES, Cell
from collplan_study.analysis.comparisons import LENGTH, PANELS, TIME, Comparison
from collplan_study.analysis.paper_results import CaseResults
from collplan_study.analysis.statistics import MEAN, SPREAD
from collplan_study.report.content import Row, Table, number, with_interval
from collplan_study.report.figures import AXIS_LABELS
from collplan_study.report.paper_pictures import CasePictures

ROWS = {
    (TIME, MEAN): "Arrival time mean",
    (TIME, SPREAD): "Arrival time STD",
    (LENGTH, MEAN): "Path length mean",
    (LENGTH, SPREAD): "Path length STD",
}


def case_tables(case: CaseResults, pictures: CasePictures) -> Iterator[Table]:
    """Every table of a case."""
    yield _table_one(case)
    yield _success(case)
    yield _impacts(case)
    yield _over_periods(case, pictures)
    if len({each.map_period for each in case.by_map_period}) > 1:
        yield _improvements(case.by_map_period)
    yield _paths(case, pictures)


def _table_one(case: CaseResults) -> Table:
    if not case.table_one:
        return Table("Table I", "One strategy alone: nothing to compare.")
    resampled = "worlds" if len(case.worlds) > 1 else "runs"
    return Table(
        "Table I",
        f"Improvement of {case.table_one[0].ours} against the others at {_periods(case)}, in percent; the {resampled} "
        f"are resampled. STD is that between {case.spread}. A run that does not arrive counts with the time limit, and "
        "with the length it drove.",
        ("Improvement [%]", "against", "simulated", "pairs", "paper", "verdict"),
        [_comparison_row(each) for each in case.table_one],
    )


def _periods(case: CaseResults) -> str:
    periods = set(case.main_periods.values())
    if len(periods) == 1:
        return f"T_map {periods.pop():g} s"
    return "T_map " + ", ".join(f"{period:g} s ({strategy})" for strategy, period in case.main_periods.items())


def _comparison_row(each: Comparison) -> Row:
    paper = "says nothing" if each.paper is None else f"{each.paper:.2f}"
    name = ROWS[each.column, each.measure]
    return name, each.other, with_interval(each.estimate, 2), str(each.pairs), paper, each.verdict


def _success(case: CaseResults) -> Table:
    return Table(
        "Success",
        "Share of runs that arrive, with Wilson's 95 % interval, and how the others end.",
        ("strategy", "runs", "arrive [%]", *OUTCOMES),
        [_success_row(cell) for cell in case.cells],
    )


def _success_row(cell: Cell) -> Row:
    outcomes = (str(cell.outcomes[outcome]) for outcome in OUTCOMES)
    return _cell_name(cell), str(cell.runs), with_interval(cell.success, 1), *outcomes


def _impacts(case: CaseResults) -> Table:
    maneuvers = (name.replace("_", " ") for name in case.cells[0].shares)
    speeds = ("hardest [m/s]", "mean speed [m/s]")
    return Table(
        "Impacts, maneuvers, planning",
        "Means over the runs, but the hardest impact and the slowest p99 of planning times, which are wall times of "
        "this machine at work. Deliberate: more than 0.2 m/s into the wall and foreseen by a plan. Maneuvers are "
        "shares of the time.",
        ("strategy", "impacts", "deliberate", "unforeseen", *speeds, *maneuvers, "candidates", "plan p99 [ms]"),
        [_impact_row(cell) for cell in case.cells],
    )


def _impact_row(cell: Cell) -> Row:
    means, largest = cell.means, cell.largest
    return (
        _cell_name(cell),
        *(number(means[name], 2) for name in ("impacts", "deliberate_impacts", "unforeseen_impacts")),
        number(largest["max_impact_speed"], 2),
        number(means["mean_speed"], 2),
        *(number(share, 3) for share in cell.shares.values()),
        number(means["candidates_mean"], 0),
        number(largest["plan_time_ms_p99"], 1),
    )


def _over_periods(case: CaseResults, pictures: CasePictures) -> Table:
    return Table(
        "Over the mapping time T_map",
        head=("strategy", *(AXIS_LABELS[panel] for panel in PANELS)),
        rows=[(_cell_name(cell), *(with_interval(each, 3) for each in cell.levels)) for cell in case.cells],
        picture=pictures.map_periods,
    )


def _improvements(comparisons: list[Comparison]) -> Table:
    places = dict.fromkeys((each.other, each.map_period) for each in comparisons)
    return Table(
        "Improvement at each T_map",
        head=("against", *ROWS.values()),
        rows=[_improvements_row(comparisons, other, period) for other, period in places],
    )


def _improvements_row(comparisons: list[Comparison], other: str, period: float) -> Row:
    estimates = [each.estimate for each in comparisons if (each.other, each.map_period) == (other, period)]
    return f"{other}, {period:g} s", *(with_interval(estimate, 2) for estimate in estimates)


def _paths(case: CaseResults, pictures: CasePictures) -> Table:
    shown = len({world for world, _ in pictures.drawn})
    fewest = f" in {shown} of {len(case.worlds)} worlds, those where the fewest arrive"
    some = fewest if shown < len(case.worlds) else ""
    return Table(
        "Paths on the map of grown obstacles",
        f"Every run{some} at {_periods(case)}; obstacles dark, grown by the robot's radius light; start a dot in the "
        "robot's outline, goal a star in its tolerance; runs that do not arrive dotted black, a cross where they end.",
        ("world", "strategy", "runs", "arrive", *(AXIS_LABELS[panel] for panel in PANELS), "impacts a run"),
        [_path_row(world, cell) for world, cell in pictures.drawn],
        pictures.paths,
    )


def _path_row(world: str, cell: Cell) -> Row:
    levels = (number(level.value, 3) for level in cell.levels)
    impacts = number(cell.means["impacts"], 2)
    return world, _cell_name(cell), str(cell.runs), str(cell.outcomes[REACHED]), *levels, impacts


def _cell_name(cell: Cell) -> str:
    return f"{cell.strategy}, {cell.map_period:g} s"
