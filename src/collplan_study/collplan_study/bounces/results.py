"""Results of a study of bounces, as table.json holds them: gains, losses, and the cost of an unknown map."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import polars as pl

from collplan_study.analysis.cells import TIME, Cell, cell_of
from collplan_study.analysis.pairs import distinct, mean_over_worlds, paired, samples, savings
from collplan_study.analysis.statistics import INTERVAL, MEAN, Estimate, level_of, share_of
from collplan_study.bounces.comparisons import (
    Gain,
    ReboundErrors,
    WorldGain,
    gain_of,
    gains_by_world,
    rebound_errors_of,
)
from collplan_study.question.bounces import KNOWN_MAP
from collplan_study.question.held_out import FAMILIES

OURS, AGAINST = "bounce", "avoid"
"""The strategy judged, and the one it is compared with in the variants and world by world.

Where one was not run, the first of the strategies takes its place."""
MAIN = "as in the main comparison"
"""Name in reports of the variant that changes nothing."""


@dataclass(frozen=True)
class Group:
    """Families of worlds that are compared together; `headline` where no other group includes them."""

    name: str
    families: tuple[str, ...]
    headline: bool

    def rows(self, all_rows: pl.DataFrame) -> pl.DataFrame:
        """The rows of the group's worlds."""
        return all_rows.filter(pl.col("family").is_in(self.families))


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
    """Cells and gain of the two strategies compared, in a group, in a variant; its name is empty for the main one."""

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
    def headlines(self) -> list[GroupResults]:
        """The groups that no other one includes."""
        return [each for each in self.groups if each.group.headline]

    @property
    def comparisons(self) -> int:
        """Number of savings of time that have an interval of their own."""
        return sum(len(each.gains) for each in self.groups) + sum(1 for each in self.variants if each.ablation)

    @property
    def changes(self) -> dict[str, list[VariantResults]]:
        """The variants of every group by their name."""
        names = dict.fromkeys(each.ablation for each in self.variants)
        return {name: [each for each in self.variants if each.ablation == name] for name in names}

    def both(self, cells: Sequence[Cell]) -> list[Cell]:
        """Cells of the two compared strategies, `ours` first."""
        return [cell for name in (self.ours, self.against) for cell in cells if cell.strategy == name]

    def record(self) -> dict[str, Any]:
        """The results as table.json holds them."""
        return {
            "results": "simulated",
            "saved": "100 (1 - t / t_other) [%] of each pair of equal world and seed, mean over the worlds' means",
            "interval": INTERVAL,
            "resampled": "the worlds",
            "not_arrived": "counted with the time limit",
            "comparisons": self.comparisons,
            **asdict(self),
        }


def bounce_results(strategies: Sequence[str], runs: pl.DataFrame, impacts: pl.DataFrame) -> BounceResults:
    """The results of a study of bounces, complete or not.

    Args:
        strategies: at least two, each at one T_map.
        runs: rows of the runs done so far.
        impacts: rows of their impacts.
    """
    ours, against, others = strategies_compared(strategies)
    main_runs, main_impacts = runs.filter(ablation=""), impacts.filter(ablation="")
    ablations, groups = distinct(runs, "ablation"), list(groups_of(main_runs))
    variants = [name for name in ablations if name != KNOWN_MAP] if len(ablations) > 1 else []
    return BounceResults(
        ours=ours,
        against=against,
        groups=[
            _group_results(group, group.rows(main_runs), group.rows(main_impacts), (ours, against), others)
            for group in groups
        ],
        variants=[
            _variant_results(group, name, group.rows(runs).filter(ablation=name), (ours, against))
            for name in variants
            for group in groups
        ],
        known_map=[
            _known_map_results(group, group.rows(runs), (ours, against)) for group in groups if KNOWN_MAP in ablations
        ],
    )


def strategies_compared(strategies: Sequence[str]) -> tuple[str, str, list[str]]:
    """Returns, of at least two strategies, the one judged, the one compared with in the variants, and all others."""
    ours = OURS if OURS in strategies else strategies[0]
    others = [strategy for strategy in strategies if strategy != ours]
    return ours, AGAINST if AGAINST in others else others[0], others


def groups_of(runs: pl.DataFrame) -> Iterator[Group]:
    """The families of held_out.FAMILIES pooled, where there are several, then each family of the runs."""
    families = distinct(runs, "family")
    together = tuple(family for family in families if family in FAMILIES)
    pooled = len(together) > 1
    if pooled:
        yield Group(f"{len(together)} families together", together, headline=True)
    for family in families:
        yield Group(family, (family,), headline=not (pooled and family in together))


def _group_results(
    group: Group, runs: pl.DataFrame, impacts: pl.DataFrame, both: tuple[str, str], others: Sequence[str]
) -> GroupResults:
    cells = _cells(runs)
    return GroupResults(
        group=group,
        cells=cells,
        rebounds=[rebound_errors_of(cell.strategy, impacts) for cell in cells],
        gains=[gain_of(runs, both[0], other) for other in others],
        worlds=gains_by_world(*(runs.filter(strategy=strategy) for strategy in both)),
    )


def _cells(runs: pl.DataFrame) -> list[Cell]:
    """The cell of every strategy, each at its one T_map."""
    cells = runs.select("strategy", "map_period_s").unique(maintain_order=True)
    return [cell_of(runs, **labels) for labels in cells.iter_rows(named=True)]


def _variant_results(group: Group, ablation: str, runs: pl.DataFrame, both: tuple[str, str]) -> VariantResults:
    cells = [cell for cell in _cells(runs) if cell.strategy in both]
    return VariantResults(group, ablation, cells, gain_of(runs, *both))


def _known_map_results(group: Group, runs: pl.DataFrame, both: tuple[str, str]) -> KnownMapResults:
    (ours, against), (ours_knowing, against_knowing) = (
        [runs.filter(ablation=name, strategy=each) for each in both] for name in ("", KNOWN_MAP)
    )
    reached, ceiling = samples(paired(savings(ours, against, TIME), savings(ours_knowing, against_knowing, TIME)))
    whole = level_of(MEAN, ceiling)
    above_zero = whole.low is not None and whole.low > 0.0
    knowing = (savings(ours_knowing, ours, TIME), savings(against_knowing, against, TIME))
    return KnownMapResults(
        group=group,
        saved_by_knowing=dict(zip(both, map(mean_over_worlds, knowing), strict=True)),
        reached=level_of(MEAN, reached),
        ceiling=whole,
        share=share_of(reached, ceiling) if above_zero else Estimate(None, note="no ceiling that is surely above zero"),
    )
