"""Rows of a study's tables, read back from their files."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from collplan_study.analysis.statistics import Sample

ByTrial = dict[str, dict[int, float]]
"""One number of each run, by world and trial."""


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of a table: one for each run, or one for each impact.

    Attributes:
        columns: (n,) arrays by name; a missing number is NaN.
    """

    columns: Mapping[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.columns["world"])

    def where(self, **values: Any) -> "Rows":
        """The rows that have these values."""
        return self.masked(np.logical_and.reduce([self.columns[name] == value for name, value in values.items()]))

    def masked(self, mask: np.ndarray) -> "Rows":
        """The rows where a mask (n,) is true."""
        return Rows({name: column[mask] for name, column in self.columns.items()})

    def dicts(self, *names: str) -> Iterator[dict[str, Any]]:
        """Every row as a dictionary of the named columns, of all when none is named."""
        names = names or tuple(self.columns)
        for row in zip(*(self.columns[name].tolist() for name in names), strict=True):
            yield dict(zip(names, row, strict=True))

    def distinct(self, name: str) -> list[Any]:
        """The values of a column in the order of their first row."""
        return list(dict.fromkeys(self.columns[name].tolist()))

    def numbers(self, name: str) -> np.ndarray:
        """The finite values of a column."""
        column = self.columns[name].astype(float)
        return column[np.isfinite(column)]

    def by_trial(self, name: str) -> ByTrial:
        """The finite values of a column, by world and trial."""
        found: ByTrial = {}
        for world, trial, value in map(dict.values, self.dicts("world", "trial", name)):
            if np.isfinite(value):
                found.setdefault(world, {})[trial] = value
        return found

    def sample(self, name: str) -> Sample:
        """The finite values of a column, an array for each world."""
        return sample_of(self.by_trial(name))


def sample_of(numbers: ByTrial) -> Sample:
    """The numbers of each world as an array."""
    return [np.array(list(trials.values())) for trials in numbers.values()]


def read_rows(path: Path) -> Rows:
    """The rows of a parquet file."""
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    return Rows({name: table.column(name).to_numpy() for name in table.column_names})
