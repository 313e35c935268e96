"""The columns of a study's tables: their names, types and order."""

from collections.abc import Sequence
from typing import Any

from collplan_core.command import MANEUVERS
from collplan_core.parameters import all_specs

LABELS: dict[str, type] = {
    "world": str,
    "family": str,
    "ablation": str,
    "engine": str,
    "strategy": str,
    "map_period_s": float,
}
"""First columns of every table: the cell of the grid that a trial belongs to. The --set axes follow, then TRIAL."""
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
"""Columns measured in a trial. Speeds in m/s; shares of the control periods, 0 to 1."""
REBOUND = ("direction_error_rad", "foreseen_speed", "measured_speed")
"""Columns of an impact's rebound, present where the last plan before the impact foresaw it; speeds in m/s."""
IMPACT: dict[str, type] = {
    "x": float,
    "y": float,
    "speed_into": float,
    "foreseen": bool,
    "deliberate": bool,
    **dict.fromkeys(REBOUND, float),
}
"""Columns of an impact: contact point [m], speed into the wall [m/s], whether a plan in force foresaw it, and whether
it was foreseen and fast enough to be deliberate."""


def columns(axes: Sequence[str]) -> dict[str, type]:
    """Name and type of every column of the trials' table, in order.

    Args:
        axes: keys of the --set axes.
    """
    known = all_specs()
    return {**LABELS, **{key: type(known[key].default) for key in axes}, **TRIAL, **MEASURES}


def axes_of(names: Sequence[str]) -> Sequence[str]:
    """Keys of the --set axes among the columns of a table."""
    return names[len(LABELS) : names.index(next(iter(TRIAL)))]


def blank() -> dict[str, Any]:
    """Measures of a trial that has none: every column None."""
    return dict.fromkeys(MEASURES)
