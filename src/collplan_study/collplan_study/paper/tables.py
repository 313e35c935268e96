"""The tables of the paper's question: those of a case, and of its ablations."""

from collections.abc import Iterator, Sequence
from functools import partial

from collplan_core.evaluation.run_end import REACHED
from collplan_study.analysis.cells import LENGTH, OUTCOMES, PANELS, TIME, Cell
from collplan_study.analysis.statistics import MEAN, SPREAD, Estimate
from collplan_study.paper.pictures import AXIS_LABELS, CasePictures
from collplan_study.paper.results import AblationResults, CaseResults
from collplan_study.report.content import Row, Section, number, with_interval

ROWS = {
    (TIME, MEAN): "Arrival time mean",
    (TIME, SPREAD): "Arrival time STD",
    (LENGTH, MEAN): "Path length mean",
    (LENGTH, SPREAD): "Path length STD",
}
IMPACTS = ("impacts", "deliberate_impacts", "unforeseen_impacts")

_Table = partial(Section, level=3)


def case_tables(case: CaseResults, pictures: CasePictures) -> Iterator[Section]:
    """Every table of a case."""
    yield _table_one(case)
    yield _Table(
        "Success",
        "Share of runs that arrive, with Wilson's 95 % interval, and how the others end.",
        ("strategy", "runs", "arrive [%]", *OUTCOMES),
        [
            (cell.name, str(cell.runs), with_interval(cell.success, 1), *(str(cell.outcomes[end]) for end in OUTCOMES))
            for cell in case.cells
        ],
    )
    yield _impacts(case)
    yield _Table(
        "Over the mapping time T_map",
        head=("strategy", *(AXIS_LABELS[panel] for panel in PANELS)),
        rows=[(cell.name, *(with_interval(each, 3) for each in cell.levels)) for cell in case.cells],
        picture=pictures.map_periods,
    )
    if len({each.map_period for each in case.by_map_period}) > 1:
        yield _improvements(case)
    yield _paths(case, pictures)


def _table_one(case: CaseResults) -> Section:
    if not case.table_one:
        return _Table("Table I", "One strategy alone: nothing to compare.")
    resampled = "worlds" if len(case.worlds) > 1 else "runs"
    return _Table(
        "Table I",
        f"Improvement of {case.table_one[0].ours} against the others at {_periods(case)}, in percent; the {resampled} "
        f"are resampled. STD is that between {case.spread}. A run that does not arrive counts with the time limit, and "
        "with the length it drove.",
        ("Improvement [%]", "against", "simulated", "pairs", "paper", "verdict"),
        [
            (
                ROWS[each.column, each.measure],
                each.other,
                with_interval(each.estimate, 2),
                str(each.pairs),
                "says nothing" if each.paper is None else f"{each.paper:.2f}",
                each.verdict,
            )
            for each in case.table_one
        ],
    )


def _periods(case: CaseResults) -> str:
    periods = set(case.main_periods.values())
    if len(periods) == 1:
        return f"T_map {periods.pop():g} s"
    return "T_map " + ", ".join(f"{period:g} s ({strategy})" for strategy, period in case.main_periods.items())


def _impacts(case: CaseResults) -> Section:
    maneuvers = (name.replace("_", " ") for name in case.cells[0].shares)
    speeds = ("hardest [m/s]", "mean speed [m/s]")
    return _Table(
        "Impacts, maneuvers, planning",
        "Means over the runs, but the hardest impact and the slowest p99 of planning times, which are wall times of "
        "this machine at work. Deliberate: more than 0.2 m/s into the wall and foreseen by a plan. Maneuvers are "
        "shares of the time.",
        ("strategy", "impacts", "deliberate", "unforeseen", *speeds, *maneuvers, "candidates", "plan p99 [ms]"),
        [
            (
                cell.name,
                *(number(cell.means[name], 2) for name in IMPACTS),
                number(cell.largest["max_impact_speed"], 2),
                number(cell.means["mean_speed"], 2),
                *(number(share, 3) for share in cell.shares.values()),
                number(cell.means["candidates_mean"], 0),
                number(cell.largest["plan_time_ms_p99"], 1),
            )
            for cell in case.cells
        ],
    )


def _improvements(case: CaseResults) -> Section:
    places: dict[str, list[str]] = {}
    for each in case.by_map_period:
        places.setdefault(f"{each.other}, {each.map_period:g} s", []).append(with_interval(each.estimate, 2))
    rows = [(place, *numbers) for place, numbers in places.items()]
    return _Table("Improvement at each T_map", head=("against", *ROWS.values()), rows=rows)


def _paths(case: CaseResults, pictures: CasePictures) -> Section:
    shown = len({world for world, _ in pictures.drawn})
    fewest = f" in {shown} of {len(case.worlds)} worlds, those where the fewest arrive"
    some = fewest if shown < len(case.worlds) else ""
    return _Table(
        "Paths on the map of grown obstacles",
        f"Every run{some} at {_periods(case)}; obstacles dark, grown by the robot's radius light; start a dot in the "
        "robot's outline, goal a star in its tolerance; runs that do not arrive dotted black, a cross where they end.",
        ("world", "strategy", "runs", "arrive", *(AXIS_LABELS[panel] for panel in PANELS), "impacts a run"),
        [
            (
                world,
                cell.name,
                str(cell.runs),
                str(cell.outcomes[REACHED]),
                *(number(level.value, 3) for level in cell.levels),
                number(cell.means["impacts"], 2),
            )
            for world, cell in pictures.drawn
        ],
        pictures.paths,
    )


def ablation_tables(found: Sequence[AblationResults]) -> Iterator[Section]:
    """A table for each case that ablations were run in."""
    for case in dict.fromkeys(each.case for each in found):
        results = [each for each in found if each.case == case]
        gains = (f"{each.ours} against {each.other}" for each in results[0].gains)
        head = ("change", *(cell.strategy for cell in results[0].cells), *gains)
        yield _Table(case, head=head, rows=[_ablation(each) for each in results])


def _ablation(found: AblationResults) -> Row:
    cells = (_cell_text(cell, longer) for cell, longer in zip(found.cells, found.longer, strict=True))
    return found.ablation, *cells, *(with_interval(each.estimate, 1, " %") for each in found.gains)


def _cell_text(cell: Cell, longer: Estimate) -> str:
    time, means = cell.levels[0].value, cell.means
    impacts = f"{number(means['deliberate_impacts'], 2)} of {number(means['impacts'], 2)} deliberate"
    lines = (f"{cell.outcomes[REACHED]}/{cell.runs}, {number(time, 2)} s", with_interval(longer, 1, " %"), impacts)
    return "\n".join(lines)
