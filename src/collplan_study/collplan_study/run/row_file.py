"""The trials of a study that were done, by their place in the grid, and the file of JSON lines that holds them."""

import fcntl
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from collplan_study.errors import StudyError
from collplan_study.question.grid import TrialGrid
from collplan_study.tables.rows import TrialRow


class JsonLines:
    """A file of records, each on the disk as soon as it is appended. What a stop has left of a last line is removed."""

    def __init__(self, path: Path) -> None:
        """Opens or creates the file and its folder.

        Raises:
            OSError: it cannot be written.
        """
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = path.open("a+b")

    def close(self) -> None:
        """Closes the file, and gives up its lock."""
        self._file.close()

    def lock(self) -> bool:
        """Keeps others out until the file is closed; whether no other process has locked it."""
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            return False
        return True

    def lines(self) -> Iterator[tuple[int, bytes]]:
        """Offset and content of every line; an incomplete last one is removed from the file."""
        self._file.seek(0)
        offset = 0
        for line in self._file:
            if not line.endswith(b"\n"):
                self._file.truncate(offset)
                return
            yield offset, line
            offset += len(line)

    def records(self) -> list[Any]:
        """Every record, in the order of the file."""
        return [json.loads(line) for _, line in self.lines()]

    def record(self, offset: int) -> Any:
        """The record of the line that begins at an offset."""
        self._file.seek(offset)
        return json.loads(self._file.readline())

    def append(self, *records: Any) -> Sequence[int]:
        """Appends records; they are on the disk when this returns. Returns the offset of each line."""
        end = self._file.seek(0, os.SEEK_END)
        lines = [json.dumps(record, allow_nan=False, separators=(",", ":")).encode() + b"\n" for record in records]
        self._file.write(b"".join(lines))
        self._file.flush()
        os.fsync(self._file.fileno())
        return [end + sum(map(len, lines[:k])) for k in range(len(lines))]


class RowFile:
    """File with one line for each trial done, in the order they ended; a trial whose line was cut off is not done.

    It is a context manager that holds a lock: only one process at a time can open the file.

    Raises:
        StudyError: another process has the file open, or a line is not a trial of this grid and code.
    """

    def __init__(self, path: Path, grid: TrialGrid, code: str) -> None:
        """Opens or creates the file of a study begun with `code`, and reads which trials it holds."""
        self._path, self._grid, self._code = path, grid, code
        self._offsets: dict[int, int] = {}
        try:
            self._file = JsonLines(path)
        except OSError as error:
            raise StudyError(f"{path}: cannot be written: {error.strerror}") from None
        try:
            if not self._file.lock():
                raise StudyError(f"{path}: another process is at work on this study")
            for number, (offset, line) in enumerate(self._file.lines(), 1):
                self._offsets[self._checked_index(number, line)] = offset
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

    def __iter__(self) -> Iterator[TrialRow]:
        """The records in the order of the grid."""
        return (self._file.record(offset) for _, offset in sorted(self._offsets.items()))

    def append(self, records: Sequence[TrialRow]) -> None:
        """Appends trials; they are on the disk when this returns."""
        self._offsets |= zip((record["index"] for record in records), self._file.append(*records), strict=True)

    def _checked_index(self, number: int, line: bytes) -> int:
        try:
            record = json.loads(line)
            index, row = record["index"], record["row"]
            known = isinstance(index, int) and 0 <= index < len(self._grid) and index not in self._offsets
            if known and _has_labels(row, self._grid.tasks[index].labels) and "path" in record:
                if record["code"] == self._code:
                    return index
                other = f"run by other code or libraries ({record['code']}), the study by {self._code}"
                raise StudyError(f"{self._path}:{number}: {other}: remove the line, or begin a new study")
        except StudyError:
            raise
        except (ValueError, KeyError, TypeError, AttributeError):
            pass
        expected = "expected a trial of this study, each once"
        raise StudyError(f"{self._path}:{number}: got {line[:60].decode(errors='replace')!r}, {expected}")


def _has_labels(row: dict[str, Any], labels: Mapping[str, Any]) -> bool:
    return all(row[key] == value for key, value in labels.items())
