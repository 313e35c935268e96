"""Files and folders of runs: there whole or not at all, locked while they are written, and the errors of those."""

import fcntl
import os
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class RunError(ValueError):
    """Error of a run that cannot be read; the text names its folder or file, and what was expected."""


class RecordError(RuntimeError):
    """Error of a file of a run that cannot be written; the text names it and the reason."""

    def __init__(self, path: Path, error: OSError) -> None:
        """Says which file, and why."""
        super().__init__(f"{path}: cannot be written: {error.strerror or error}")


class FolderLock:
    """Held from its construction until it is closed, or its process ends, whatever ends it.

    On construction BlockingIOError: another holds it. OSError: the folder cannot be read, or is where a file system
    knows no locks.
    """

    def __init__(self, folder: Path) -> None:
        """Takes the lock."""
        descriptor = os.open(folder, os.O_RDONLY)
        self.close = weakref.finalize(self, os.close, descriptor)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self.close()
            raise


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
