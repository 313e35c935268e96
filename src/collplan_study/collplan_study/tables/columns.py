"""The columns of the table."""

from collections.abc import Sequence
from typing import Any

from collplan_core.command import MANEUVERS
from collplan_core.parameters import all_specs

LABELS: dict[str, type] = {
    "world": str,
    "family": str,
    "ablation": str,
    "strategy": str,
    "map_period_s": float,
}
"""Of a cell; then come the axes, then the trial."""
TRIAL: dict[str, type] = {"trial": int, "seed": int}
SHARES = tuple(f"share_{maneuver}" for maneuver in MANEUVERS)
MEASURES: dict[str, type] = {
    "outcome": str,
    "arrival_time_s": float,
    "path_length_m": float,
    "impacts": int,
    "deliberate_impacts": int,
    "unforeseen_impacts": int,
    "mean_speed": float,
    "max_impact_speed": float,
    "plans": int,
    "candidates_mean": float,
    "candidates_before_pruning_mean": float,
    **dict.fromkeys(SHARES, float),
    "plan_time_ms_p50": float,
    "plan_time_ms_p99": float,
    "wall_time_s": float,
    "error": str,
}
REBOUND = ("direction_error_rad", "foreseen_speed", "measured_speed")
"""Of a rebound that a plan foresaw."""
IMPACT: dict[str, type] = {
    "x": float,
    "y": float,
    "speed_into": float,
    "foreseen": bool,
    **dict.fromkeys(REBOUND, float),
}
"""Of each impact: contact point [m], speed into the wall [m/s], whether a plan in force foresaw it."""
WALL_TIMES = ("plan_time_ms_p50", "plan_time_ms_p99", "wall_time_s")
"""The columns in which two runs of one study differ."""


def columns(axes: Sequence[str]) -> dict[str, type]:
    """Name and type of every column, in order."""
    known = all_specs()
    return {**LABELS, **{key: type(known[key].default) for key in axes}, **TRIAL, **MEASURES}


def blank() -> dict[str, Any]:
    """The measures of a trial that has none."""
    return dict.fromkeys(MEASURES)
