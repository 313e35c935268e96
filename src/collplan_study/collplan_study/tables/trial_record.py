"""The record of a trial: its row of the table, its path and its impacts."""

from math import isfinite
from typing import Any, TypedDict

import numpy as np

from collplan_core.command import MANEUVERS
from collplan_study.tables.columns import REBOUND, blank
from omnipuck_sim.trial_record import TrialResult, speeds_into

ERROR = "error"
PATH_RATE = 20.0
"""Points of a path per second [Hz]."""
PATH_UNIT = 1e-4
"""Paths are kept in whole multiples of this [m]."""

Path = dict[str, list[int]]
NO_PATH: Path = {"t_ms": [], "x": [], "y": []}


class TrialRow(TypedDict):
    """One trial as JSON holds it: its place in the grid, every column by name, its sampled path, a row per impact."""

    index: int
    row: dict[str, Any]
    path: Path
    impacts: list[dict[str, Any]]


def measures(result: TrialResult, wall_time: float) -> dict[str, Any]:
    """The measured columns of a trial that took `wall_time` [s]; None where there is nothing to measure."""
    times = 1e3 * result.plan_times
    return {
        "outcome": result.outcome,
        "arrival_time_s": result.arrival_time,
        "path_length_m": result.path_length,
        **_impact_measures(result),
        "mean_speed": _mean_speed(result),
        "plans": len(result.plans),
        "candidates_mean": _mean(result.candidates),
        "candidates_before_pruning_mean": _mean(result.candidates_before_pruning),
        **_shares(result.maneuvers),
        "plan_time_ms_p50": float(np.percentile(times, 50)) if len(times) else None,
        "plan_time_ms_p99": float(np.percentile(times, 99)) if len(times) else None,
        "wall_time_s": wall_time,
        "error": "",
    }


def error_measures(error: Exception) -> dict[str, Any]:
    """The measured columns of a trial that raised."""
    message = " ".join(f"{type(error).__name__}: {error}".split())
    return {**blank(), "outcome": ERROR, "error": message}


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
    points = [impact.point.tolist() for impact in result.impacts]
    flags = zip(speeds_into(result.impacts).tolist(), result.foreseen.tolist(), result.deliberate.tolist(), strict=True)
    return [
        {"x": x, "y": y, "speed_into": speed, "foreseen": foreseen, "deliberate": deliberate, **_rebound(rebound)}
        for (x, y), (speed, foreseen, deliberate), rebound in zip(points, flags, result.rebounds.tolist(), strict=True)
    ]


def _rebound(numbers: list[float]) -> dict[str, float | None]:
    return {name: value if isfinite(value) else None for name, value in zip(REBOUND, numbers, strict=True)}


def _impact_measures(result: TrialResult) -> dict[str, Any]:
    return {
        "impacts": len(result.impacts),
        "deliberate_impacts": int(result.deliberate.sum()),
        "unforeseen_impacts": int((~result.foreseen).sum()),
        "max_impact_speed": float(speeds_into(result.impacts).max(initial=0.0)),
    }


def _mean_speed(result: TrialResult) -> float | None:
    trajectory = result.trajectory
    if len(trajectory) == 0 or trajectory[-1, 0] <= 0.0:
        return None
    return float(result.path_length / trajectory[-1, 0])


def _mean(counts: np.ndarray) -> float | None:
    return float(counts.mean()) if len(counts) else None


def _shares(periods: dict[str, int]) -> dict[str, float | None]:
    total = sum(periods.values())
    return {f"share_{maneuver}": periods.get(maneuver, 0) / total if total else None for maneuver in MANEUVERS}
