"""The row of a trial, its path and its impacts: names, types and order of the columns, and what stands in them."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np

from collplan_core.command import MANEUVERS
from collplan_core.parameters import all_specs
from omnipuck_sim.trial_record import TrialResult

LABELS: dict[str, type] = {
    **dict.fromkeys(("world", "family", "ablation", "engine", "strategy"), str),
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
    **dict.fromkeys(("x", "y", "speed_into"), float),
    **dict.fromkeys(("foreseen", "deliberate"), bool),
    **dict.fromkeys(REBOUND, float),
}
"""Columns of an impact: contact point [m], speed into the wall [m/s], whether a plan in force foresaw it, and whether
it was foreseen and fast enough to be deliberate."""
ERROR = "error"
PATH_RATE = 20.0
"""Points of a path per second [Hz]."""
PATH_UNIT = 1e-4
"""Paths are kept in whole multiples of this [m]."""

Path = dict[str, list[int]]
NO_PATH: Path = {"t_ms": [], "x": [], "y": []}
TrialRow = dict[str, Any]
"""A trial as JSON holds it: its `index` in the grid, the `code` that ran it, its `row` of columns, its `path`, and a
row for each of its `impacts`."""


def columns(axes: Sequence[str]) -> dict[str, type]:
    """Name and type of every column of the trials' table, in order; `axes` are the keys of the --set axes."""
    known = all_specs()
    return {**LABELS, **{key: type(known[key].default) for key in axes}, **TRIAL, **MEASURES}


def axes_of(names: Sequence[str]) -> Sequence[str]:
    """Keys of the --set axes among the columns of a table."""
    return names[len(LABELS) : names.index(next(iter(TRIAL)))]


def measures(result: TrialResult, wall_time: float) -> dict[str, Any]:
    """The measured columns of a trial that took `wall_time` [s]; None where there is nothing to measure."""
    times, trajectory, periods = 1e3 * result.plan_times, result.trajectory, sum(result.maneuvers.values())
    moved = len(trajectory) > 0 and trajectory[-1, 0] > 0.0
    return {
        "outcome": result.outcome,
        "arrival_time_s": result.arrival_time,
        "path_length_m": result.path_length,
        "impacts": len(result.impacts),
        "deliberate_impacts": int(result.deliberate.sum()),
        "unforeseen_impacts": int((~result.foreseen).sum()),
        "mean_speed": float(result.path_length / trajectory[-1, 0]) if moved else None,
        "max_impact_speed": max((impact.speed_into for impact in result.impacts), default=0.0),
        "plans": len(result.plans),
        "candidates_mean": _mean(result.candidates),
        "candidates_before_pruning_mean": _mean(result.candidates_before_pruning),
        **{f"share_{each}": result.maneuvers.get(each, 0) / periods if periods else None for each in MANEUVERS},
        "plan_time_ms_p50": float(np.percentile(times, 50)) if len(times) else None,
        "plan_time_ms_p99": float(np.percentile(times, 99)) if len(times) else None,
        "wall_time_s": wall_time,
        "error": "",
    }


def _mean(counts: np.ndarray) -> float | None:
    return float(counts.mean()) if len(counts) else None


def error_measures(error: Exception) -> dict[str, Any]:
    """The measured columns of a trial that raised."""
    message = " ".join(f"{type(error).__name__}: {error}".split())
    return {**dict.fromkeys(MEASURES), "outcome": ERROR, "error": message}


def sampled_path(trajectory: np.ndarray) -> Path:
    """Time [ms] and position [PATH_UNIT] at PATH_RATE, and at the end, of a trajectory (m, 5) t, x, y, vx, vy."""
    if len(trajectory) == 0:
        return NO_PATH
    times = trajectory[:, 0]
    first, last = times[[0, -1]]
    # half a millisecond early: sums of decimal times must not decide
    wanted = np.arange(first, last, 1.0 / PATH_RATE) - 5e-4
    rows = trajectory[np.unique(np.append(np.searchsorted(times, wanted), len(times) - 1))]
    scaled = np.rint(rows[:, :3] / [1e-3, PATH_UNIT, PATH_UNIT]).astype(int)
    return dict(zip(NO_PATH, scaled.T.tolist(), strict=True))


def impact_rows(result: TrialResult) -> list[dict[str, Any]]:
    """The columns of each impact of a trial, in their order; None where there is nothing to compare."""
    found = zip(result.impacts, result.foreseen.tolist(), result.deliberate.tolist(), result.rebounds, strict=True)
    return [
        dict(zip(IMPACT, (*impact.point.tolist(), impact.speed_into, foreseen, deliberate, *rebound), strict=True))
        for impact, foreseen, deliberate, rebounds in found
        for rebound in [[value if isfinite(value) else None for value in rebounds.tolist()]]
    ]
