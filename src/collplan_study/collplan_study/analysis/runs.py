"""The table of a study, read back, and its parts: a case is what one Table I is made of."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from collplan_study.analysis.statistics import Sample
from collplan_study.tables.columns import LABELS, TRIAL

ByTrial = dict[str, dict[int, float]]
"""One number of each run, by world and trial."""


@dataclass(frozen=True, eq=False)
class Runs:
    """Rows of the table.

    Attributes:
        columns: (n,) each by name; a number that is missing is NaN.
    """

    columns: Mapping[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.columns["world"])

    def where(self, **values: Any) -> "Runs":
        """The rows that have these values."""
        return self.kept(np.logical_and.reduce([self.columns[name] == value for name, value in values.items()]))

    def kept(self, chosen: np.ndarray) -> "Runs":
        """The rows of a mask (n,)."""
        return Runs({name: column[chosen] for name, column in self.columns.items()})

    def rows(self, *names: str) -> Iterator[dict[str, Any]]:
        """Row by row these columns, all when none is named."""
        names = names or tuple(self.columns)
        for row in zip(*(self.columns[name].tolist() for name in names), strict=True):
            yield dict(zip(names, row, strict=True))

    def distinct(self, name: str) -> list[Any]:
        """The values of a column in the order they come."""
        return list(dict.fromkeys(self.columns[name].tolist()))

    def numbers(self, name: str) -> np.ndarray:
        """A column without the runs that lack it."""
        column = self.columns[name].astype(float)
        return column[np.isfinite(column)]

    def by_trial(self, name: str) -> ByTrial:
        """A column by world and trial, without the runs that lack it."""
        found: ByTrial = {}
        for world, trial, value in map(dict.values, self.rows("world", "trial", name)):
            if np.isfinite(value):
                found.setdefault(world, {})[trial] = value
        return found

    def sample(self, name: str) -> Sample:
        """A column by world, without the runs that lack it."""
        return sample_of(self.by_trial(name))


def sample_of(numbers: ByTrial) -> Sample:
    """The numbers of each world."""
    return [np.array(list(trials.values())) for trials in numbers.values()]


@dataclass(frozen=True, eq=False)
class Case:
    """The runs of one family of worlds at one point of the axes and with one ablation.

    Attributes:
        ablation: "" is none.
        point: value of each --set axis by key.
    """

    family: str
    ablation: str
    point: Mapping[str, Any]
    runs: Runs

    @property
    def name(self) -> str:
        """In words."""
        values = [f"{key} = {value}" for key, value in self.point.items()]
        return ", ".join([self.family, *values, *([self.ablation] if self.ablation else [])])


def read_runs(path: Path) -> Runs:
    """The rows of trials.parquet."""
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    return Runs({name: table.column(name).to_numpy() for name in table.column_names})


def axes_of(runs: Runs) -> tuple[str, ...]:
    """Keys of the --set axes, which stand between the labels and the trial."""
    names = list(runs.columns)
    return tuple(names[len(LABELS) : names.index(next(iter(TRIAL)))])


def cases_of(runs: Runs) -> Iterator[Case]:
    """Every case, in the order of the table."""
    keys = ("family", "ablation", *axes_of(runs))
    for values in dict.fromkeys(zip(*(runs.columns[key].tolist() for key in keys), strict=True)):
        family, ablation, *point = values
        labels = dict(zip(keys, values, strict=True))
        yield Case(family, ablation, dict(zip(keys[2:], point, strict=True)), runs.where(**labels))
