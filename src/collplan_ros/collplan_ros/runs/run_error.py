"""The error of whoever reads a run."""


class RunError(ValueError):
    """A folder without a readable run; the text names file, line and column, and what was expected."""
