"""Values of a DiagnosticStatus by key, by attributes alone: also of one read without ROS."""

import math
from collections.abc import Mapping
from typing import Any

REAL_TIME_FACTOR = "real_time_factor"
"""Simulated seconds in the last second, of a simulator that publishes /clock."""


def values_of(status: Any) -> dict[str, str]:
    """Values by key; of two with the same key the later one."""
    return {str(item.key): str(item.value) for item in status.values}


def real_time_factor(values: Mapping[str, str]) -> float | None:
    """The real-time factor among a node's values; None where it has none, or no finite number."""
    try:
        factor = float(values[REAL_TIME_FACTOR])
    except (KeyError, ValueError):
        return None
    return factor if math.isfinite(factor) else None
