"""The cases of a study of the paper's question: what one Table I is made of."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from collplan_study.analysis.rows import Rows
from collplan_study.tables.columns import LABELS, TRIAL


@dataclass(frozen=True, eq=False)
class Case:
    """The runs of one family of worlds at one point of the axes and with one ablation.

    Attributes:
        family: family of the worlds.
        ablation: its name; empty without one.
        point: value of each --set axis by key.
        runs: rows of the case.
    """

    family: str
    ablation: str
    point: Mapping[str, Any]
    runs: Rows

    @property
    def name(self) -> str:
        """Family, values of the axes and ablation as text."""
        values = [f"{key} = {value}" for key, value in self.point.items()]
        return ", ".join([self.family, *values, *([self.ablation] if self.ablation else [])])


def axes_of(runs: Rows) -> tuple[str, ...]:
    """Keys of the --set axes, whose columns stand between the labels and the trial."""
    names = list(runs.columns)
    return tuple(names[len(LABELS) : names.index(next(iter(TRIAL)))])


def cases_of(runs: Rows) -> Iterator[Case]:
    """Every case, in the order of the table."""
    keys = ("family", "ablation", *axes_of(runs))
    for values in dict.fromkeys(zip(*(runs.columns[key].tolist() for key in keys), strict=True)):
        family, ablation, *point = values
        labels = dict(zip(keys, values, strict=True))
        yield Case(family, ablation, dict(zip(keys[2:], point, strict=True)), runs.where(**labels))
