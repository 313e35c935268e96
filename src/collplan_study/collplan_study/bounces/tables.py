"""The tables of a study of bounces, for its page and its document."""

from collections.abc import Iterator

from collplan_core.evaluation.run_end import ABORTED, REACHED, STUCK, TIMEOUT
from collplan_study.analysis.cells import Cell
from collplan_study.bounces.comparisons import Gain
from collplan_study.bounces.results import BounceResults, VariantResults
from collplan_study.report.content import Row, Section, number, with_interval
from collplan_study.tables.rows import ERROR

LEAST = 6
"""Worlds listed of each headline group, those where least is saved."""
MAIN = "as in the main comparison"
"""Name of the variant that changes nothing."""


def bounce_tables(results: BounceResults) -> Iterator[Section]:
    """Every table of which the study has rows."""
    yield from _gains(results)
    yield _strategies(results)
    yield _contacts(results)
    yield _rebounds(results)
    yield _least_saved(results)
    if results.known_map:
        yield _known_map(results)
    if results.variants:
        yield _variants(results)
        yield from _details(results)


def _gains(results: BounceResults) -> Iterator[Section]:
    others = (gain.other for gain in results.groups[0].gains)
    yield Section(
        f"Arrival time saved by {results.ours} [%]",
        "Mean over the worlds of 100 (1 - t / t_other), equal world and equal noise; in brackets 95 %.",
        ("worlds", "number", "pairs", *(f"against {other}" for other in others)),
        [
            (
                each.group.name,
                str(each.gains[0].worlds),
                str(each.gains[0].pairs),
                *(with_interval(gain.saved, 1) for gain in each.gains),
            )
            for each in results.groups
        ],
    )
    yield Section(
        "What is lost",
        f"Share of the pairs in which {results.ours} arrives later, and by how much its path is longer.",
        ("worlds", "against", "arrives later [% of pairs]", "path longer [%]"),
        [(each.group.name, gain.other, *_losses(gain)) for each in results.groups for gain in each.gains],
    )


def _losses(gain: Gain) -> Row:
    return with_interval(gain.slower, 1), with_interval(gain.longer, 1)


def _strategies(results: BounceResults) -> Section:
    return Section(
        "Each strategy",
        "Wilson's interval of the share that arrives; a run that does not arrive counts with the time limit and the "
        "length it drove.",
        ("worlds", "strategy", "runs", "arrive [%]", "how others end", "time [s]", "path [m]"),
        [
            (
                each.group.name,
                cell.strategy,
                str(cell.runs),
                with_interval(cell.success, 1),
                _other_ends(cell),
                number(cell.levels[0].value, 3),
                number(cell.levels[2].value, 3),
            )
            for each in results.groups
            for cell in each.cells
        ],
    )


def _other_ends(cell: Cell) -> str:
    ends = (TIMEOUT, STUCK, ABORTED, ERROR)
    return ", ".join(f"{cell.outcomes[end]} {end}" for end in ends if cell.outcomes[end]) or "none"


def _contacts(results: BounceResults) -> Section:
    impacts = ("impacts", "deliberate", "unforeseen", "into the wall [m/s]", "hardest [m/s]")
    return Section(
        "Each strategy's impacts and planning",
        "Impacts are means over the runs. Deliberate: more than 0.2 m/s into the wall and foreseen. Planning times are "
        "wall times of this machine at work: the mean of the runs' medians, the slowest p99.",
        ("worlds", "strategy", *impacts, "plan p50 [ms]", "p99 [ms]"),
        [
            (
                each.group.name,
                cell.strategy,
                *(number(cell.means[name], 2) for name in ("impacts", "deliberate_impacts", "unforeseen_impacts")),
                number(rebounds.speed_into, 2),
                number(cell.largest["max_impact_speed"], 2),
                number(cell.means["plan_time_ms_p50"], 1),
                number(cell.largest["plan_time_ms_p99"], 1),
            )
            for each in results.groups
            for cell, rebounds in zip(each.cells, each.rebounds, strict=True)
        ],
    )


def _rebounds(results: BounceResults) -> Section:
    off = "direction off, median [deg]"
    return Section(
        "Rebounds, foreseen and true",
        "Of the impacts that the last plan before them foresaw: angle between the foreseen velocity after the impact "
        "and the true one, and true speed less foreseen speed.",
        ("worlds", "strategy", "impacts", "foreseen", off, "90 % [deg]", "speed off, median [m/s]", "deliberate", off),
        [
            (
                group.group.name,
                each.strategy,
                str(each.impacts),
                str(each.foreseen),
                number(each.direction_error, 1),
                number(each.direction_error_p90, 1),
                number(each.speed_error, 2),
                str(each.deliberate),
                number(each.deliberate_direction_error, 1),
            )
            for group in results.headlines
            for each in group.rebounds
        ],
    )


def _least_saved(results: BounceResults) -> Section:
    counts = ", ".join(
        f"{sum(world.saved < 0.0 for world in each.worlds)} of {len(each.worlds)} ({each.group.name})"
        for each in results.headlines
    )
    return Section(
        f"Worlds where {results.ours} saves least against {results.against}",
        f"Slower in the mean of its pairs in {counts}.",
        ("world", "pairs", "saved [%]", f"{results.ours} [s]", f"{results.against} [s]"),
        [
            (each.world, str(each.pairs), number(each.saved, 1), number(each.ours_time, 2), number(each.other_time, 2))
            for group in results.headlines
            for each in group.worlds[:LEAST]
        ],
    )


def _known_map(results: BounceResults) -> Section:
    both = (results.ours, results.against)
    return Section(
        "What not knowing the map costs [%]",
        f"Arrival time that the same strategy saves when it is given the map; time that {results.ours} saves against "
        f"{results.against} with what the robot sees and when both are given the map (the ceiling), in the same pairs; "
        "and the share of that ceiling that is reached.",
        ("worlds", *(f"{name} would save" for name in both), "saved", "ceiling", "share of the ceiling"),
        [
            (
                each.group.name,
                *(with_interval(each.saved_by_knowing[name], 1) for name in both),
                with_interval(each.reached, 1),
                with_interval(each.ceiling, 1),
                with_interval(each.share, 0),
            )
            for each in results.known_map
        ],
    )


def _variants(results: BounceResults) -> Section:
    by_name: dict[str, list[str]] = {}
    for each in results.variants:
        by_name.setdefault(each.ablation, []).append(with_interval(each.gain.saved, 1))
    return Section(
        f"One thing changed at a time: time saved by {results.ours} against {results.against} [%]",
        "What is not named is as in the main comparison. A restitution is the true one and the believed one, where "
        "nothing else is said.",
        ("change", *(each.group.name for each in results.groups)),
        [(name or MAIN, *found) for name, found in by_name.items()],
    )


def _details(results: BounceResults) -> Iterator[Section]:
    losses = ("arrives later [% of pairs]", "path longer [%]")
    for group in (each.group for each in results.headlines):
        yield Section(
            f"One thing changed at a time: {group.name}",
            f"{results.ours} / {results.against}.",
            ("change", "arrive", "time [s]", "deliberate impacts", "saved [%]", *losses),
            [_detail(each, results) for each in results.variants if each.group == group],
        )


def _detail(each: VariantResults, results: BounceResults) -> Row:
    cells = {cell.strategy: cell for cell in each.cells}
    both = [cells[name] for name in (results.ours, results.against) if name in cells]
    return (
        each.ablation or MAIN,
        " / ".join(f"{cell.outcomes[REACHED]} of {cell.runs}" for cell in both),
        " / ".join(number(cell.levels[0].value, 2) for cell in both),
        " / ".join(number(cell.means["deliberate_impacts"], 2) for cell in both),
        with_interval(each.gain.saved, 1),
        *_losses(each.gain),
    )
