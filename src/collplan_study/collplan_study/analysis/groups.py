"""Groups of world families that the study of bounces compares: several families pooled, and each by itself."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from collplan_study.analysis.rows import Rows
from collplan_study.question.held_out import FAMILIES


@dataclass(frozen=True)
class Group:
    """A group of families.

    Attributes:
        name: in reports.
        families: their names.
        headline: whether no other group includes these families.
    """

    name: str
    families: tuple[str, ...]
    headline: bool

    def rows(self, all_rows: Rows) -> Rows:
        """The rows of the group's worlds."""
        return all_rows.masked(np.isin(all_rows.columns["family"], self.families))


def groups_of(runs: Rows) -> Iterator[Group]:
    """The families of held_out.FAMILIES pooled, where there are several, then each family of the runs."""
    families = runs.distinct("family")
    together = tuple(family for family in families if family in FAMILIES)
    pooled = len(together) > 1
    if pooled:
        yield Group(f"{len(together)} families together", together, headline=True)
    for family in families:
        yield Group(family, (family,), headline=not (pooled and family in together))
