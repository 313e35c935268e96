"""Files of JSON lines, and that of the trials of a study that were done, by their place in the grid."""

import fcntl
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from collplan_study.errors import StudyError
from collplan_study.question.grid import Task
from collplan_study.run.rows import TrialRow


class JsonLines:
    """A file of records, each on the disk as soon as it is appended. What a stop has left of a last line is removed."""

    def __init__(self, path: Path) -> None:
        """Opens or creates the file and its folder."""
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = path.open("a+b")

    def close(self) -> None:
        """Closes the file, and gives up the lock of a RowFile."""
        self._file.close()

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


class RowFile(JsonLines):
    """One line for each trial done, in the order they ended; a trial whose line was cut off is not done."""

    def __init__(self, path: Path, grid: Sequence[Task], code: str) -> None:
        """Opens and locks the file of a study begun with `code`, and reads which trials of its grid it holds."""
        super().__init__(path)
        self._grid, self._code, self._offsets = grid, code, dict[int, int]()
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise StudyError(f"{path}: another process is at work on this study") from None
        for number, (offset, line) in enumerate(self.lines(), 1):
            self._offsets[self._checked_index(f"{path}:{number}", line)] = offset

    def __len__(self) -> int:
        return len(self._offsets)

    def __contains__(self, index: int) -> bool:
        return index in self._offsets

    def __iter__(self) -> Iterator[TrialRow]:
        """The records in the order of the grid."""
        return (self.record(offset) for _, offset in sorted(self._offsets.items()))

    def append(self, *records: TrialRow) -> Sequence[int]:
        """Appends trials, as JsonLines does."""
        offsets = super().append(*records)
        self._offsets |= zip((record["index"] for record in records), offsets, strict=True)
        return offsets

    def _checked_index(self, place: str, line: bytes) -> int:
        try:
            record = json.loads(line)
            index, row, code = record["index"], record["row"], record.get("code")
            is_new = index >= 0 and index not in self._offsets and "path" in record
            known = is_new and row.items() >= self._grid[index].labels.items()
        except (ValueError, LookupError, TypeError, AttributeError):
            known = False
        if not known:
            got = line[:60].decode(errors="replace")
            raise StudyError(f"{place}: got {got!r}, expected a trial of this study, each once")
        if code != self._code:
            other = f"run by other code or libraries ({code}), the study by {self._code}"
            raise StudyError(f"{place}: {other}: remove the line, or begin a new study")
        return int(index)
