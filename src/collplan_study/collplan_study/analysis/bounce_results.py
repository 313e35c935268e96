"""table.json of a study of bounces: what they bring, where they lose, what not knowing the map costs."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from collplan_study.analysis.cells import Cell, cell_of
from collplan_study.analysis.comparisons import TIME
from collplan_study.analysis.gains import Gain, WorldGain, gain_of, gains_by_world, mean_over_worlds, savings
from collplan_study.analysis.groups import Group, groups_of
from collplan_study.analysis.rebounds import Rebounds, rebounds_of
from collplan_study.analysis.runs import Runs
from collplan_study.analysis.statistics import LEVEL, MEAN, RESAMPLES, SEED, Estimate, level_of, paired, share_of
from collplan_study.question.bounces import KNOWN_MAP

OURS, AGAINST = "bounce", "avoid"
"""What is compared, and with what in the ablations and world by world; where they were not run, the first two."""


@dataclass(frozen=True)
class GroupResults:
    """Of the main comparison in a group of families.

    Attributes:
        cells, rebounds: by strategy.
        gains: of the first strategy against each other one.
        worlds: the gain against the strategy `against` of the results, those where most is lost first.
    """

    group: Group
    cells: list[Cell]
    rebounds: list[Rebounds]
    gains: list[Gain]
    worlds: list[WorldGain]


@dataclass(frozen=True)
class VariantResults:
    """Of one change of the main comparison in a group, "" for none: the two strategies compared, and the gain."""

    group: Group
    ablation: str
    cells: list[Cell]
    gain: Gain


@dataclass(frozen=True)
class KnownMapResults:
    """What not knowing the map costs in a group.

    Attributes:
        saved_by_knowing: 100 (1 - t_known / t) [%] by strategy.
        reached: gain [%] with what the robot sees, in the pairs that were also run with the map known.
        ceiling: gain [%] with the map known to both.
        share: of the ceiling that is reached [%].
    """

    group: Group
    saved_by_knowing: dict[str, Estimate]
    reached: Estimate
    ceiling: Estimate
    share: Estimate


@dataclass(frozen=True)
class BounceResults:
    """Of a study of bounces; `ours` against `against` where nothing else is said."""

    ours: str
    against: str
    groups: list[GroupResults]
    variants: list[VariantResults]
    known_map: list[KnownMapResults]

    @property
    def comparisons(self) -> int:
        """How many savings of time have an interval of their own."""
        return sum(len(each.gains) for each in self.groups) + sum(1 for each in self.variants if each.ablation)

    def record(self) -> dict[str, Any]:
        """As table.json holds it."""
        return {
            "results": "simulated",
            "saved": "100 (1 - t / t_other) [%] of each pair of equal world and seed, mean over the worlds' means",
            "interval": {"level": LEVEL, "method": "bootstrap, BCa", "resamples": RESAMPLES, "seed": SEED},
            "resampled": "the worlds",
            "not_arrived": "counted with the time limit",
            "comparisons": self.comparisons,
            **asdict(self),
        }  # fmt: skip


def bounce_results_of(strategies: Sequence[str], runs: Runs, impacts: Runs) -> BounceResults:
    """All that is found in the rows of a study and of its impacts.

    Args:
        strategies: at least two, each at one T_map.
        runs, impacts: perhaps not all of them yet.
    """
    ours = OURS if OURS in strategies else strategies[0]
    others = [strategy for strategy in strategies if strategy != ours]
    against = AGAINST if AGAINST in others else others[0]
    shipped, hits = runs.where(ablation=""), impacts.where(ablation="")
    ablations, groups = runs.distinct("ablation"), list(groups_of(shipped))
    varied = [name for name in ablations if name != KNOWN_MAP] if len(ablations) > 1 else []
    return BounceResults(
        ours, against,
        [_of_group(group, group.runs(shipped), group.runs(hits), ours, others, against) for group in groups],
        [_variant(group, name, group.runs(runs), ours, against) for name in varied for group in groups],
        [_known_map(group, group.runs(runs), ours, against) for group in groups if KNOWN_MAP in ablations],
    )  # fmt: skip


def _of_group(group: Group, runs: Runs, hits: Runs, ours: str, others: Sequence[str], against: str) -> GroupResults:
    cells = list(_cells(runs))
    gains = [gain_of(runs, ours, other) for other in others]
    worlds = gains_by_world(runs.where(strategy=ours), runs.where(strategy=against))
    return GroupResults(group, cells, [rebounds_of(cell.strategy, hits) for cell in cells], gains, worlds)


def _cells(runs: Runs) -> Iterator[Cell]:
    for strategy in runs.distinct("strategy"):
        (period,) = runs.where(strategy=strategy).distinct("map_period_s")
        yield cell_of(strategy, period, runs)


def _variant(group: Group, ablation: str, runs: Runs, ours: str, against: str) -> VariantResults:
    changed = runs.where(ablation=ablation)
    cells = [cell for cell in _cells(changed) if cell.strategy in (ours, against)]
    return VariantResults(group, ablation, cells, gain_of(changed, ours, against))


def _known_map(group: Group, runs: Runs, ours: str, against: str) -> KnownMapResults:
    seen, known = runs.where(ablation=""), runs.where(ablation=KNOWN_MAP)
    gains = [savings(each.where(strategy=ours), each.where(strategy=against), TIME) for each in (seen, known)]
    reached, ceiling = paired(*gains)
    whole = level_of(MEAN, ceiling)
    above_zero = whole.low is not None and whole.low > 0.0
    return KnownMapResults(
        group,
        {name: _saved(known.where(strategy=name), seen.where(strategy=name)) for name in (ours, against)},
        level_of(MEAN, reached), whole,
        share_of(reached, ceiling) if above_zero else Estimate(None, note="no ceiling that is surely above zero"),
    )  # fmt: skip


def _saved(ours: Runs, other: Runs) -> Estimate:
    return mean_over_worlds(savings(ours, other, TIME))
