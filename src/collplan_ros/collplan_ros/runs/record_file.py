"""record.jsonl: what came of a run, on disk while it goes on, one JSON array a line.

The first entry of a line is its kind; kinds and entries are in `record_reading`. Numbers that are not finite are
written as Python's json does.
"""

import json
import time
from pathlib import Path

FLUSH_PERIOD = 0.5
"""Longest time for which lines are kept in memory [s]."""


class RecordError(RuntimeError):
    """A file of a run cannot be written; the text names it and says why."""

    def __init__(self, path: Path, error: OSError) -> None:
        """Says which file, and why."""
        super().__init__(f"{path}: cannot be written: {error.strerror or error}")


class RecordFile:
    """Appends lines; what was flushed survives the end of this process, whatever ends it."""

    def __init__(self, path: Path) -> None:
        """The file is made with the first line."""
        self._path = path
        self._lines: list[str] = []
        self._flushed = time.monotonic()
        self._failed = False

    def write(self, kind: str, *entries: object) -> None:
        """Takes a line; it is on disk after the next flush."""
        if not self._failed:
            self._lines.append(json.dumps([kind, *entries], separators=(",", ":")))

    def flush_when_due(self) -> None:
        """Flushes, FLUSH_PERIOD after the last time.

        Raises:
            RecordError: the file cannot be written, the first time that this is noticed.
        """
        if time.monotonic() - self._flushed >= FLUSH_PERIOD:
            self.flush()

    def flush(self) -> None:
        """Hands all lines to the operating system.

        Raises:
            RecordError: the file cannot be written, the first time that this is noticed.
        """
        lines, self._lines = self._lines, []
        self._flushed = time.monotonic()
        if not lines or self._failed:
            return
        try:
            # opened each time: nothing is left open or in a buffer when the process ends
            with self._path.open("ab", buffering=0) as file:
                rest = ("\n".join(lines) + "\n").encode()
                while rest:
                    rest = rest[file.write(rest) :]
        except OSError as error:
            self._failed = True
            raise RecordError(self._path, error) from None
