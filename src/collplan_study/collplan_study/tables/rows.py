"""What is kept of a trial: its row of the table, its path and its impacts."""

from math import isfinite
from typing import Any

import numpy as np

from collplan_core.command import MANEUVERS
from collplan_core.evaluation.impact_matching import DELIBERATE_SPEED
from collplan_study.tables.columns import IMPACT, blank
from omnipuck_sim.trial import TrialResult

ERROR = "error"
PATH_RATE = 20.0
"""Points of a path per second [Hz]."""
PATH_UNIT = 1e-4
"""Paths are kept in whole multiples of this [m]."""

Path = dict[str, list[int]]
NO_PATH: Path = {"t_ms": [], "x": [], "y": []}


def measures(result: TrialResult, wall_time: float) -> dict[str, Any]:
    """The measured columns of a trial that took `wall_time` [s]; None where there is nothing to measure."""
    times = 1e3 * result.plan_times
    return {
        "outcome": result.outcome,
        "arrival_time_s": result.arrival_time,
        "path_length_m": result.path_length,
        **_impacts(result),
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
    """Time [ms] and place [PATH_UNIT] at PATH_RATE, and at the end, of a trajectory (m, 5) t, x, y, vx, vy."""
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
    points = np.array([impact.point for impact in result.impacts]).reshape(-1, 2)
    numbers = np.column_stack([points, _into(result), result.foreseen, result.rebounds])
    rows = [[value if isfinite(value) else None for value in row] for row in numbers.tolist()]
    return [{**dict(zip(IMPACT, row, strict=True)), "foreseen": bool(row[3])} for row in rows]


def _into(result: TrialResult) -> np.ndarray:
    """Speed into the wall (k,) of each impact [m/s]."""
    return np.array([-(impact.velocity_before @ impact.normal) for impact in result.impacts])


def _impacts(result: TrialResult) -> dict[str, Any]:
    into = _into(result)
    foreseen = result.foreseen
    return {
        "impacts": len(into),
        "deliberate_impacts": int((foreseen & (into > DELIBERATE_SPEED)).sum()),
        "unforeseen_impacts": int((~foreseen).sum()),
        "max_impact_speed": float(into.max(initial=0.0)),
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
