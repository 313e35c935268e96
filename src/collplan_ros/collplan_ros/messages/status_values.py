"""Values of a DiagnosticStatus by key, by attributes alone: also of one read without ROS."""

from typing import Any


def values_of(status: Any) -> dict[str, str]:
    """Values by key; of two with the same key the later one."""
    return {str(item.key): str(item.value) for item in status.values}
