"""Error that keeps a run from being read or written."""

from pathlib import Path


class RunError(ValueError):
    """A run cannot be read; the text names its folder or file, and what was expected."""


class RecordError(RuntimeError):
    """A file of a run cannot be written; the text names it and says why."""

    def __init__(self, path: Path, error: OSError) -> None:
        """Says which file, and why."""
        super().__init__(f"{path}: cannot be written: {error.strerror or error}")
