"""Writes the tables of a study in the order of the grid: trials.parquet, trajectories, impacts."""

import os
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from collplan_study.question.grid import TrialGrid
from collplan_study.tables.rows import IMPACT, LABELS, PATH_UNIT, TRIAL, TrialRow, columns

TABLE, PATHS, IMPACTS = "trials.parquet", "trajectories.parquet", "impacts.parquet"
CHUNK = 1000
"""Trials held in memory at once."""
ARROW = {str: pa.string(), float: pa.float64(), int: pa.int64(), bool: pa.bool_()}
PATH_FIELDS = [pa.field(name, pa.list_(pa.float32())) for name in ("t", "x", "y")]


def write_tables(folder: Path, grid: TrialGrid, records: Iterable[TrialRow]) -> None:
    """Writes the tables of a study from its records in the order of the grid."""
    kinds = columns(grid.axes)
    rows = _schema(kinds)
    labels = [rows.field(name) for name in (*LABELS, *grid.axes, *TRIAL)]
    paths, impacts = pa.schema([*labels, *PATH_FIELDS]), pa.schema([*labels, *_schema(IMPACT)])
    parts = {name: folder / f".{name}.part" for name in (TABLE, PATHS, IMPACTS)}
    with (
        pq.ParquetWriter(parts[TABLE], rows, compression="zstd") as table,
        pq.ParquetWriter(parts[PATHS], paths, compression="zstd") as path_table,
        pq.ParquetWriter(parts[IMPACTS], impacts, compression="zstd") as impact_table,
    ):
        for chunk in _chunks(records):
            table.write_table(pa.Table.from_pylist([record["row"] for record in chunk], schema=rows))
            path_table.write_table(pa.Table.from_pylist([_path_row(record) for record in chunk], schema=paths))
            impact_table.write_table(pa.Table.from_pylist(list(_impact_rows(chunk)), schema=impacts))
    for name, part in parts.items():
        os.replace(part, folder / name)


def _schema(kinds: Mapping[str, type]) -> pa.Schema:
    return pa.schema([pa.field(name, ARROW[kind]) for name, kind in kinds.items()])


def _chunks(records: Iterable[TrialRow]) -> Iterator[list[TrialRow]]:
    remaining = iter(records)
    return iter(lambda: list(islice(remaining, CHUNK)), [])


def _path_row(record: TrialRow) -> dict[str, Any]:
    path = record["path"]
    units = {"t": ("t_ms", 1e-3), "x": ("x", PATH_UNIT), "y": ("y", PATH_UNIT)}
    return {**record["row"], **{name: np.array(path[key]) * unit for name, (key, unit) in units.items()}}


def _impact_rows(chunk: Iterable[TrialRow]) -> Iterator[dict[str, Any]]:
    for record in chunk:
        for impact in record["impacts"]:
            yield {**record["row"], **impact}
