"""The command `compare_engines`: two studies of bounces that differ in the engine alone, in one table."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from collplan_core.parameters import Simulation
from collplan_core.worlds import WorldError
from collplan_study.analysis.bounce_results import strategies_compared
from collplan_study.analysis.engine_comparisons import EngineComparison, engine_comparisons
from collplan_study.errors import StudyError
from collplan_study.report.bounce_tables import MAIN
from collplan_study.report.content import Row, Table, with_interval
from collplan_study.report.markdown import markdown_table
from collplan_study.report.study_data import StudyData, read_study

DESCRIPTION = "Prints what deliberate bounces save by two engines, over the same worlds and seeds, as a Markdown table."
REFUSED = 2


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of `compare_engines`; exit code 2 where the studies cannot be compared."""
    parsed = _parser().parse_args(args)
    try:
        print("\n".join(comparison(read_study(parsed.first), read_study(parsed.second))))
    except (StudyError, WorldError, OSError) as error:
        print(f"compare_engines: {error}", file=sys.stderr)
        return REFUSED
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="compare_engines", description=DESCRIPTION)
    parser.add_argument("first", type=Path, help="folder of a study made with --bounces")
    parser.add_argument("second", type=Path, help="folder of the same study with another --engine")
    return parser


def comparison(first: StudyData, second: StudyData) -> Iterator[str]:
    """Lines of the comparison of two studies.

    Raises:
        StudyError: they are not of bounces, have the same engine, or differ in more than the engine.
    """
    _check_comparable(first, second)
    ours, against, _ = strategies_compared(first.provenance["question"]["strategies"])
    engines = _engine(first), _engine(second)
    found = engine_comparisons(first.provenance["question"]["strategies"], first.runs, second.runs)
    codes = [data.provenance["code"]["trial"] for data in (first, second)]
    yield "All figures are simulated."
    yield ""
    if codes[0] != codes[1]:
        yield f"The studies were made by different code ({codes[0]} and {codes[1]}): a difference may be of the code."
        yield ""
    yield from markdown_table(
        Table(
            f"Arrival time that {ours} saves against {against}, by {engines[0]} and by {engines[1]} [%]",
            "Mean over the worlds of 100 (1 - t / t_other) of equal worlds and seeds, in the pairs that both studies "
            "have; the difference is paired by world and seed; in brackets 95 % bootstrap intervals (BCa) over worlds.",
            ("worlds", "change", "number", "pairs", *engines, f"{engines[1]} less {engines[0]}"),
            [_row(each) for each in found],
        )
    )


def _row(each: EngineComparison) -> Row:
    numbers = (with_interval(estimate, 1) for estimate in (each.first, each.second, each.difference))
    return each.group.name, each.ablation or MAIN, str(each.worlds), str(each.pairs), *numbers


def _check_comparable(first: StudyData, second: StudyData) -> None:
    for data in (first, second):
        if not data.provenance["question"].get("bounces"):
            raise StudyError(f"{data.folder}: not a study of bounces, expected one made with --bounces")
    if _engine(first) == _engine(second):
        raise StudyError(f"{second.folder}: engine {_engine(second)} as in {first.folder}, expected another --engine")
    asked, also = first.provenance["question"], second.provenance["question"]
    for part in asked.keys() | also.keys():
        if part != "engine" and asked.get(part) != also.get(part):
            raise StudyError(f"{second.folder}: its {part} is {also.get(part)!r}, expected {asked.get(part)!r}")


def _engine(data: StudyData) -> str:
    return str(data.provenance["question"].get("engine", Simulation().engine))
