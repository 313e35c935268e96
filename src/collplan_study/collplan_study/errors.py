"""What stops a study."""


class StudyError(ValueError):
    """Something asked for cannot be done; no trial was run for it. One line that names the value."""


class WorkersLost(RuntimeError):
    """What ran the trials ended or cannot be reached; the rows so far are kept."""
