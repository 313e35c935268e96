"""Results of a study of bounces, as table.json holds them: gains, losses, and the cost of an unknown map."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from collplan_study.analysis.cells import Cell, cell_of
from collplan_study.analysis.comparisons import TIME
from collplan_study.analysis.gains import Gain, WorldGain, gain_of, gains_by_world, mean_over_worlds, savings
from collplan_study.analysis.groups import Group, groups_of
from collplan_study.analysis.rebound_errors import ReboundErrors, rebound_errors_of
from collplan_study.analysis.rows import Rows
from collplan_study.analysis.statistics import LEVEL, MEAN, RESAMPLES, SEED, Estimate, level_of, paired, share_of
from collplan_study.question.bounces import KNOWN_MAP

OURS, AGAINST = "bounce", "avoid"
"""The strategy judged, and the one it is compared with in the variants and world by world.

Where one was not run, the first of the strategies takes its place."""


@dataclass(frozen=True)
class GroupResults:
    """Results of the main comparison in a group of families.

    Attributes:
        group: the families.
        cells, rebounds: runs and rebound errors of every strategy.
        gains: gains of the strategy judged against each other one.
        worlds: gain in each world against `BounceResults.against`, ascending.
    """

    group: Group
    cells: list[Cell]
    rebounds: list[ReboundErrors]
    gains: list[Gain]
    worlds: list[WorldGain]


@dataclass(frozen=True)
class VariantResults:
    """Results of a variant of the main comparison in a group of families.

    Attributes:
        group: the families.
        ablation: name of the variant; empty for the main comparison.
        cells: cells of the two strategies compared.
        gain: gain of one over the other.
    """

    group: Group
    ablation: str
    cells: list[Cell]
    gain: Gain


@dataclass(frozen=True)
class KnownMapResults:
    """Cost of an unknown map in a group of families.

    Attributes:
        group: the families.
        saved_by_knowing: 100 (1 - t_known / t) [%] by strategy, t_known with the map given.
        reached: gain [%] without the map, in the pairs that were also run with it.
        ceiling: gain [%] with the map given to both strategies.
        share: `reached` over `ceiling` [%].
    """

    group: Group
    saved_by_knowing: dict[str, Estimate]
    reached: Estimate
    ceiling: Estimate
    share: Estimate


@dataclass(frozen=True)
class BounceResults:
    """Results of a study of bounces: of the strategy `ours` against `against`, unless stated otherwise."""

    ours: str
    against: str
    groups: list[GroupResults]
    variants: list[VariantResults]
    known_map: list[KnownMapResults]

    @property
    def comparisons(self) -> int:
        """Number of savings of time that have an interval of their own."""
        return sum(len(each.gains) for each in self.groups) + sum(1 for each in self.variants if each.ablation)

    def record(self) -> dict[str, Any]:
        """The results as table.json holds them."""
        return {
            "results": "simulated",
            "saved": "100 (1 - t / t_other) [%] of each pair of equal world and seed, mean over the worlds' means",
            "interval": {"level": LEVEL, "method": "bootstrap, BCa", "resamples": RESAMPLES, "seed": SEED},
            "resampled": "the worlds",
            "not_arrived": "counted with the time limit",
            "comparisons": self.comparisons,
            **asdict(self),
        }


def bounce_results_of(strategies: Sequence[str], runs: Rows, impacts: Rows) -> BounceResults:
    """The results of a study of bounces, complete or not.

    Args:
        strategies: at least two, each at one T_map.
        runs: rows of the runs done so far.
        impacts: rows of their impacts.
    """
    ours, against, others = strategies_compared(strategies)
    main_runs, main_impacts = runs.where(ablation=""), impacts.where(ablation="")
    ablations, groups = runs.distinct("ablation"), list(groups_of(main_runs))
    variants = [name for name in ablations if name != KNOWN_MAP] if len(ablations) > 1 else []
    return BounceResults(
        ours=ours,
        against=against,
        groups=[_group_results(group, main_runs, main_impacts, ours, against, others) for group in groups],
        variants=[_variant_results(group, name, runs, ours, against) for name in variants for group in groups],
        known_map=[_known_map_results(group, runs, ours, against) for group in groups if KNOWN_MAP in ablations],
    )


def strategies_compared(strategies: Sequence[str]) -> tuple[str, str, list[str]]:
    """Of at least two strategies the one judged, the one it is compared with in the variants, and all other ones."""
    ours = OURS if OURS in strategies else strategies[0]
    others = [strategy for strategy in strategies if strategy != ours]
    return ours, AGAINST if AGAINST in others else others[0], others


def _group_results(
    group: Group, all_runs: Rows, all_impacts: Rows, ours: str, against: str, others: Sequence[str]
) -> GroupResults:
    runs, impacts = group.rows(all_runs), group.rows(all_impacts)
    cells = list(_cells(runs))
    return GroupResults(
        group=group,
        cells=cells,
        rebounds=[rebound_errors_of(cell.strategy, impacts) for cell in cells],
        gains=[gain_of(runs, ours, other) for other in others],
        worlds=gains_by_world(runs.where(strategy=ours), runs.where(strategy=against)),
    )


def _cells(runs: Rows) -> Iterator[Cell]:
    for strategy in runs.distinct("strategy"):
        (period,) = runs.where(strategy=strategy).distinct("map_period_s")
        yield cell_of(strategy, period, runs)


def _variant_results(group: Group, ablation: str, all_runs: Rows, ours: str, against: str) -> VariantResults:
    runs = group.rows(all_runs).where(ablation=ablation)
    cells = [cell for cell in _cells(runs) if cell.strategy in (ours, against)]
    return VariantResults(group, ablation, cells, gain_of(runs, ours, against))


def _known_map_results(group: Group, all_runs: Rows, ours: str, against: str) -> KnownMapResults:
    runs = group.rows(all_runs)
    seen, known = runs.where(ablation=""), runs.where(ablation=KNOWN_MAP)
    gains = [savings(each.where(strategy=ours), each.where(strategy=against), TIME) for each in (seen, known)]
    reached, ceiling = paired(*gains)
    whole = level_of(MEAN, ceiling)
    above_zero = whole.low is not None and whole.low > 0.0
    return KnownMapResults(
        group=group,
        saved_by_knowing={
            name: _saved(known.where(strategy=name), seen.where(strategy=name)) for name in (ours, against)
        },
        reached=level_of(MEAN, reached),
        ceiling=whole,
        share=share_of(reached, ceiling) if above_zero else Estimate(None, note="no ceiling that is surely above zero"),
    )


def _saved(ours: Rows, other: Rows) -> Estimate:
    return mean_over_worlds(savings(ours, other, TIME))
