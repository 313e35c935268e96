"""Everything that a report is made from, read from the folder of a study."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import polars as pl

from collplan_study.errors import StudyError
from collplan_study.question.sources import Source
from collplan_study.run.study_folder import read_provenance, read_sources
from collplan_study.tables.table_files import IMPACTS, TABLE


@dataclass(frozen=True, eq=False)
class StudyData:
    """A study whose tables were written.

    Attributes:
        folder: folder of the study.
        provenance: content of provenance.json.
        sources: the worlds.
        runs, impacts: rows of the runs done so far and of their impacts.
    """

    folder: Path
    provenance: Mapping[str, Any]
    sources: tuple[Source, ...]
    runs: pl.DataFrame
    impacts: pl.DataFrame


def read_study(folder: Path) -> StudyData:
    """The study in a folder.

    Raises:
        StudyError: the folder does not hold a study, or a table of it is missing or cut off.
        WorldError: one of its world files cannot be read.
    """
    provenance = read_provenance(folder)
    tables = [_table(folder / name) for name in (TABLE, IMPACTS)]
    return StudyData(folder, provenance, read_sources(folder, provenance), *tables)


def _table(path: Path) -> pl.DataFrame:
    try:
        return pl.read_parquet(path)
    except (OSError, pl.exceptions.PolarsError):
        raise StudyError(f"{path}: missing or cut off, study --resume {path.parent} makes it anew") from None
