"""An append-only file of the trials done, which can be read again after a stop at any moment."""

import fcntl
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from collplan_study.errors import StudyError
from collplan_study.question.grid import Grid
from collplan_study.tables.trial_record import TrialRecord


class RowFile:
    """File with one line of JSON for each trial done, in the order they ended.

    It is a context manager that holds a lock: only one process at a time can open the file. An incomplete last line is
    removed; its trial counts as not done.

    Raises:
        StudyError: another process has the file open, or a line is not a trial of this grid.
    """

    def __init__(self, path: Path, grid: Grid) -> None:
        """Opens or creates the file and reads which trials it holds."""
        self._path, self._grid = path, grid
        self._offsets: dict[int, int] = {}
        try:
            self._file = path.open("a+b")
        except OSError as error:
            raise StudyError(f"{path}: cannot be written: {error.strerror}") from None
        try:
            self._lock()
            self._read()
        except StudyError:
            self._file.close()
            raise

    def __enter__(self) -> "RowFile":
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()

    def __len__(self) -> int:
        return len(self._offsets)

    def __contains__(self, index: int) -> bool:
        return index in self._offsets

    def __iter__(self) -> Iterator[TrialRecord]:
        """The records in the order of the grid."""
        for _, offset in sorted(self._offsets.items()):
            self._file.seek(offset)
            yield json.loads(self._file.readline())

    def append(self, records: Sequence[TrialRecord]) -> None:
        """Appends trials; they are on the disk when this returns."""
        end = self._file.seek(0, os.SEEK_END)
        lines = [json.dumps(record, allow_nan=False, separators=(",", ":")).encode() + b"\n" for record in records]
        self._file.write(b"".join(lines))
        self._file.flush()
        os.fsync(self._file.fileno())
        for record, line in zip(records, lines, strict=True):
            self._offsets[record["index"]] = end
            end += len(line)

    def _lock(self) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise StudyError(f"{self._path}: another process is at work on this study") from None

    def _read(self) -> None:
        self._file.seek(0)
        offset = 0
        for number, line in enumerate(self._file, 1):
            if not line.endswith(b"\n"):
                self._file.truncate(offset)
                return
            self._offsets[self._checked_index(number, line)] = offset
            offset += len(line)

    def _checked_index(self, number: int, line: bytes) -> int:
        try:
            record = json.loads(line)
            index, row = record["index"], record["row"]
            known = isinstance(index, int) and 0 <= index < len(self._grid) and index not in self._offsets
            if known and _has_labels(row, self._grid.task(index).labels) and "path" in record:
                return index
        except (ValueError, KeyError, TypeError, AttributeError):
            pass
        expected = "expected a trial of this study, each once"
        raise StudyError(f"{self._path}:{number}: got {line[:60].decode(errors='replace')!r}, {expected}")


def _has_labels(row: dict[str, Any], labels: Mapping[str, Any]) -> bool:
    return all(row[key] == value for key, value in labels.items())
