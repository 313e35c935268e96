"""Files that are there whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from collplan_ros.run.run_error import RecordError


def has_end(path: Path) -> bool:
    """Returns whether a text file is there and ends with its last line."""
    try:
        with path.open("rb") as file:
            file.seek(-1, os.SEEK_END)
            return file.read() == b"\n"
    except OSError:  # an empty one has no last byte
        return False


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Gives the path of a file to write beside `path`, which takes its place on leaving, or is removed on an error.

    Raises:
        RecordError: it cannot be written.
    """
    unfinished = path.with_name(f".{path.stem}_{os.getpid()}{path.suffix}")
    try:
        yield unfinished
        with unfinished.open("rb") as file:
            os.fsync(file.fileno())
        os.replace(unfinished, path)
    except OSError as error:
        raise RecordError(path, error) from None
    finally:
        unfinished.unlink(missing_ok=True)
