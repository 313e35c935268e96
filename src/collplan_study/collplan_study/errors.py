"""Errors that stop a study."""


class StudyError(ValueError):
    """An option, file or folder cannot be used; no trial was run. One line that names the value."""


class WorkersLost(RuntimeError):
    """The workers ended, cannot be reached or have other code; the rows so far are kept."""
