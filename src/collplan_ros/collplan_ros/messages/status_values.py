"""Values of a DiagnosticStatus by key, by attributes alone: also of one read without ROS."""

import math
from collections.abc import Mapping
from typing import Any

from collplan_core.learning.drive import Drive
from collplan_ros.messages.reading import MessageError

REAL_TIME_FACTOR = "real_time_factor"
"""Simulated seconds in the last second, of a simulator that publishes /clock."""

DRIVE = ("max_acceleration", "velocity_lag", "motion_delay")
"""Values of controller/drive that planner and controller use; what was learnt of each, and between which two values it
is in nine of ten, follows as NAME.learnt, NAME.low and NAME.high."""


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


def drive_from_message(status: Any) -> Drive:
    """The drive in use of controller/drive. Raises MessageError as `drive_figures`."""
    figures = drive_figures(status)
    return Drive(*(figures[name] for name in DRIVE))


def drive_figures(status: Any) -> dict[str, float]:
    """The figures of controller/drive [m/s^2], [s]; MessageError: one in use is missing, or one is no finite number."""
    values = values_of(status)
    try:
        figures = {name: float(value) for name, value in values.items()}
    except ValueError as error:
        raise MessageError(f"values: {error}") from None
    if not set(DRIVE) <= set(figures) or not all(map(math.isfinite, figures.values())):
        raise MessageError(f"values: got {values}, expected finite {', '.join(DRIVE)}")
    return figures
