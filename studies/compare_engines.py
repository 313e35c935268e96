"""The command `compare_engines`: two studies of bounces that differ in the engine alone, in one table."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from collplan_core.parameters import Simulation
from collplan_core.worlds import WorldError
from collplan_study.analysis.bounce_results import strategies_compared
from collplan_study.analysis.comparisons import TIME
from collplan_study.analysis.gains import mean_over_worlds, savings
from collplan_study.analysis.groups import Group, groups_of
from collplan_study.analysis.rows import ByTrial, Rows
from collplan_study.analysis.statistics import MEAN, Estimate, level_of, paired
from collplan_study.errors import StudyError
from collplan_study.question.bounces import KNOWN_MAP
from collplan_study.report.bounce_tables import MAIN
from collplan_study.report.content import Row, Table, with_interval
from collplan_study.report.markdown import markdown_table
from collplan_study.report.study_data import StudyData, read_study

DESCRIPTION = "Prints what deliberate bounces save by two engines, over the same worlds and seeds, as a Markdown table."
REFUSED = 2


@dataclass(frozen=True)
class EngineComparison:
    """One variant in a group of families: arrival time saved [%] in each of two studies, and by how much more.

    Attributes:
        group: the families.
        ablation: name of the variant; empty for the main comparison.
        worlds, pairs: numbers of those that both studies have; of the one study where the other lacks the variant.
        first, second: saved in each, in what both have.
        difference: of the second less the first, paired by world and seed.
    """

    group: Group
    ablation: str
    worlds: int
    pairs: int
    first: Estimate
    second: Estimate
    difference: Estimate


def engine_comparisons(strategies: Sequence[str], first: Rows, second: Rows) -> Iterator[EngineComparison]:
    """The main comparison in every group of families, then each variant in those that no other group includes.

    Args:
        strategies: those of both studies.
        first, second: rows of the runs of the two studies.
    """
    groups = list(groups_of(first.where(ablation="")))
    changes = dict.fromkeys([*first.distinct("ablation"), *second.distinct("ablation")])
    for ablation in (change for change in changes if change != KNOWN_MAP):
        for group in groups:
            if group.headline or not ablation:
                saved = [_saved(group.rows(runs).where(ablation=ablation), strategies) for runs in (first, second)]
                yield _paired_by_world(group, ablation, *saved)


def _saved(runs: Rows, strategies: Sequence[str]) -> ByTrial:
    ours, against, _ = strategies_compared(strategies)
    return savings(runs.where(strategy=ours), runs.where(strategy=against), TIME)


def _paired_by_world(group: Group, ablation: str, first: ByTrial, second: ByTrial) -> EngineComparison:
    if not (first and second):
        found = first or second
        none = Estimate(None, note="not run in both")
        saved = [mean_over_worlds(each) if each else none for each in (first, second)]
        return EngineComparison(group, ablation, len(found), sum(map(len, found.values())), saved[0], saved[1], none)
    one, other = paired(first, second)
    differences = [theirs - ours for ours, theirs in zip(one, other, strict=True)]
    return EngineComparison(
        group=group,
        ablation=ablation,
        worlds=len(one),
        pairs=sum(map(len, one)),
        first=level_of(MEAN, one),
        second=level_of(MEAN, other),
        difference=level_of(MEAN, differences),
    )


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


if __name__ == "__main__":
    sys.exit(main())
