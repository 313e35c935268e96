"""What deliberate bounces save in one study of bounces and in another that differs in the engine alone."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from collplan_study.analysis.bounce_results import strategies_compared
from collplan_study.analysis.comparisons import TIME
from collplan_study.analysis.gains import mean_over_worlds, savings
from collplan_study.analysis.groups import Group, groups_of
from collplan_study.analysis.rows import ByTrial, Rows
from collplan_study.analysis.statistics import MEAN, Estimate, level_of, paired
from collplan_study.question.bounces import KNOWN_MAP


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
                yield _comparison(group, ablation, *saved)


def _saved(runs: Rows, strategies: Sequence[str]) -> ByTrial:
    ours, against, _ = strategies_compared(strategies)
    return savings(runs.where(strategy=ours), runs.where(strategy=against), TIME)


def _comparison(group: Group, ablation: str, first: ByTrial, second: ByTrial) -> EngineComparison:
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
