"""Error that keeps a run from being read or written."""

from pathlib import Path


class RunError(ValueError):
    """Error of a run that cannot be read; the text names its folder or file, and what was expected."""


class RecordError(RuntimeError):
    """Error of a file of a run that cannot be written; the text names it and the reason."""

    def __init__(self, path: Path, error: OSError) -> None:
        """Says which file, and why."""
        super().__init__(f"{path}: cannot be written: {error.strerror or error}")
