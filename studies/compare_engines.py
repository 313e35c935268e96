"""The command `compare_engines`: two studies of bounces that differ in the engine alone, in one table."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import polars as pl

from collplan_core.parameters import Simulation
from collplan_core.worlds import WorldError
from collplan_study.analysis.cells import TIME
from collplan_study.analysis.pairs import VALUE, distinct, mean_over_worlds, paired, savings
from collplan_study.analysis.statistics import Estimate
from collplan_study.bounces.results import MAIN, Group, groups_of, strategies_compared
from collplan_study.errors import StudyError
from collplan_study.question.bounces import KNOWN_MAP
from collplan_study.report.content import with_interval
from collplan_study.report.study_data import StudyData, read_study
from markdown_text import Row, Section, markdown

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


def engine_comparisons(
    strategies: Sequence[str], first: pl.DataFrame, second: pl.DataFrame
) -> Iterator[EngineComparison]:
    """The main comparison in every group of families, then each variant in those that no other group includes.

    Args:
        strategies: those of both studies.
        first, second: rows of the runs of the two studies.
    """
    groups = list(groups_of(first.filter(ablation="")))
    changes = dict.fromkeys([*distinct(first, "ablation"), *distinct(second, "ablation")])
    for ablation in (change for change in changes if change != KNOWN_MAP):
        for group in groups:
            if group.headline or not ablation:
                saved = [_saved(group.rows(runs).filter(ablation=ablation), strategies) for runs in (first, second)]
                yield _paired_by_world(group, ablation, *saved)


def _saved(runs: pl.DataFrame, strategies: Sequence[str]) -> pl.DataFrame:
    ours, against, _ = strategies_compared(strategies)
    return savings(runs.filter(strategy=ours), runs.filter(strategy=against), TIME)


def _paired_by_world(group: Group, ablation: str, first: pl.DataFrame, second: pl.DataFrame) -> EngineComparison:
    if first.is_empty() or second.is_empty():
        none = Estimate(None, note="not run in both")
        found = second if first.is_empty() else first
        saved = [none if each.is_empty() else mean_over_worlds(each) for each in (first, second)]
        return EngineComparison(group, ablation, len(distinct(found, "world")), found.height, saved[0], saved[1], none)
    both = paired(first, second)
    return EngineComparison(
        group=group,
        ablation=ablation,
        worlds=len(distinct(both, "world")),
        pairs=both.height,
        first=mean_over_worlds(both, "ours"),
        second=mean_over_worlds(both, "other"),
        difference=mean_over_worlds(both.with_columns((pl.col("other") - pl.col("ours")).alias(VALUE))),
    )


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of `compare_engines`; exit code 2 where the studies cannot be compared."""
    parsed = _parser().parse_args(args)
    try:
        print(comparison(read_study(parsed.first), read_study(parsed.second)))
    except (StudyError, WorldError, OSError) as error:
        print(f"compare_engines: {error}", file=sys.stderr)
        return REFUSED
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="compare_engines", description=DESCRIPTION)
    parser.add_argument("first", type=Path, help="folder of a study made with --bounces")
    parser.add_argument("second", type=Path, help="folder of the same study with another --engine")
    return parser


def comparison(first: StudyData, second: StudyData) -> str:
    """The comparison of two studies in Markdown.

    Raises:
        StudyError: they are not of bounces, have the same engine, or differ in more than the engine.
    """
    _check_comparable(first, second)
    ours, against, _ = strategies_compared(first.provenance["question"]["strategies"])
    engines = _engine(first), _engine(second)
    found = engine_comparisons(first.provenance["question"]["strategies"], first.runs, second.runs)
    code, other = (data.provenance["code"]["trial"] for data in (first, second))
    differs = f"The studies were made by different code ({code} and {other}): a difference may be of the code."
    return markdown(
        Section(note="All figures are simulated."),
        Section(note=differs if code != other else ""),
        Section(
            f"Arrival time that {ours} saves against {against}, by {engines[0]} and by {engines[1]} [%]",
            "Mean over the worlds of 100 (1 - t / t_other) of equal worlds and seeds, in the pairs that both studies "
            "have; the difference is paired by world and seed; in brackets 95 % bootstrap intervals (BCa) over worlds.",
            ("worlds", "change", "number", "pairs", *engines, f"{engines[1]} less {engines[0]}"),
            [_row(each) for each in found],
        ),
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
