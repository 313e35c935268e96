"""A file with one record a line, as JSON, which can be read again after a stop at any moment."""

import fcntl
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any


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
