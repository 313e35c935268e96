"""The tables of a study: written in the order of the grid, and read for its report."""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from collplan_study.errors import StudyError
from collplan_study.question.grid import Source, Task
from collplan_study.run.rows import IMPACT, MEASURES, PATH_UNIT, TrialRow, axes_of, columns
from collplan_study.run.study_folder import read_provenance, read_sources

TABLE, PATHS, IMPACTS = "trials.parquet", "trajectories.parquet", "impacts.parquet"
PATH = {"t": ("t_ms", 1e-3), "x": ("x", PATH_UNIT), "y": ("y", PATH_UNIT)}
"""Columns of a path: the name of each in a record, and its unit there [s, m]."""


def write_tables(folder: Path, grid: Sequence[Task], records: Iterable[TrialRow]) -> None:
    """Writes the tables of a study from its records in the order of the grid."""
    names = columns(axes_of(list(grid[0].labels)))
    labels = {name: kind for name, kind in names.items() if name not in MEASURES}
    tables: dict[str, tuple[Mapping[str, Any], list[Any]]] = {
        TABLE: (names, []),
        PATHS: ({**labels, **dict.fromkeys(PATH, pl.List(pl.Float32))}, []),
        IMPACTS: ({**labels, **IMPACT}, []),
    }
    for record in records:
        row, path = record["row"], record["path"]
        of_labels = {name: row[name] for name in labels}
        tables[TABLE][1].append(row)
        points = {name: np.array(path[key], dtype=float) * unit for name, (key, unit) in PATH.items()}
        tables[PATHS][1].append(of_labels | {name: values.astype(np.float32) for name, values in points.items()})
        tables[IMPACTS][1].extend(of_labels | impact for impact in record["impacts"])
    for file, (kinds, rows) in tables.items():
        part = folder / f".{file}.part"
        pl.DataFrame(rows, schema=kinds, orient="row").write_parquet(part)
        os.replace(part, folder / file)


@dataclass(frozen=True, eq=False)
class StudyData:
    """A study whose tables were written."""

    folder: Path
    provenance: Mapping[str, Any]
    sources: tuple[Source, ...]
    runs: pl.DataFrame
    """Rows of the runs done so far."""
    impacts: pl.DataFrame
    """Rows of their impacts."""


def read_study(folder: Path) -> StudyData:
    """The study in a folder; a StudyError or a WorldError where a file of it is missing or cut off."""
    provenance = read_provenance(folder)
    tables = [_table(folder / name) for name in (TABLE, IMPACTS)]
    return StudyData(folder, provenance, read_sources(folder, provenance), *tables)


def _table(path: Path) -> pl.DataFrame:
    try:
        return pl.read_parquet(path)
    except (OSError, pl.exceptions.PolarsError):
        raise StudyError(f"{path}: missing or cut off, study --resume {path.parent} makes it anew") from None
