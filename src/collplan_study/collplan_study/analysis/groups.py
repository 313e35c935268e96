"""Families of worlds that are judged together, or each by itself."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from collplan_study.analysis.runs import Runs
from collplan_study.question.held_out import FAMILIES


@dataclass(frozen=True)
class Group:
    """Families by name; a headline is one that no other group holds."""

    name: str
    families: tuple[str, ...]
    headline: bool

    def runs(self, all_runs: Runs) -> Runs:
        """Those in its worlds."""
        return all_runs.kept(np.isin(all_runs.columns["family"], self.families))


def groups_of(runs: Runs) -> Iterator[Group]:
    """Those of held_out.FAMILIES together, where there are several, then each family."""
    families = runs.distinct("family")
    together = tuple(family for family in families if family in FAMILIES)
    pooled = len(together) > 1
    if pooled:
        yield Group(f"{len(together)} families together", together, headline=True)
    for family in families:
        yield Group(family, (family,), headline=not (pooled and family in together))
