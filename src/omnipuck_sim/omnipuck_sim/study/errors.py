"""What stops a study."""


class StudyError(ValueError):
    """Something asked for cannot be done; no trial was run for it. One line that names the value."""
