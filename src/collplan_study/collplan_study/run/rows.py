"""The rows of a trial and the tables made of them: names, types and order of the columns, what stands in them."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from collplan_core.command import MANEUVERS
from collplan_core.parameters import all_specs
from collplan_study.question.grid import Task
from omnipuck_sim.trial_record import TrialResult


def _share(maneuver: str, result: TrialResult) -> float | None:
    periods = sum(result.maneuvers.values())
    return result.maneuvers.get(maneuver, 0) / periods if periods else None


def over(statistic: Callable[..., Any], values: np.ndarray) -> float | None:
    """A statistic of values; None where there is none."""
    return float(statistic(values)) if len(values) else None


def _mean_speed(result: TrialResult) -> float | None:
    moved = len(result.trajectory) > 0 and result.trajectory[-1, 0] > 0.0
    return float(result.path_length / result.trajectory[-1, 0]) if moved else None


LABELS: dict[str, type] = {
    **dict.fromkeys(("world", "family", "ablation", "engine", "strategy"), str),
    "map_period_s": float,
}
"""First columns of every table: the cell of the grid that a trial belongs to. The --set axes follow, then TRIAL."""
TRIAL: dict[str, type] = {"trial": int, "seed": int}
SHARES = tuple(f"share_{maneuver}" for maneuver in MANEUVERS)
MEASURED: dict[str, tuple[type, Callable[[TrialResult], Any]]] = {
    "outcome": (str, lambda result: result.outcome),
    "arrival_time_s": (float, lambda result: result.arrival_time),
    "path_length_m": (float, lambda result: result.path_length),
    "impacts": (int, lambda result: len(result.impacts)),
    "deliberate_impacts": (int, lambda result: int(result.deliberate.sum())),
    "unforeseen_impacts": (int, lambda result: int((~result.foreseen).sum())),
    "mean_speed": (float, _mean_speed),
    "max_impact_speed": (float, lambda result: max((hit.speed_into for hit in result.impacts), default=0.0)),
    "plans": (int, lambda result: len(result.plans)),
    "candidates_mean": (float, lambda result: over(np.mean, result.candidates)),
    "candidates_before_pruning_mean": (float, lambda result: over(np.mean, result.candidates_before_pruning)),
    **{name: (float, partial(_share, maneuver)) for name, maneuver in zip(SHARES, MANEUVERS, strict=True)},
    "plan_time_ms_p50": (float, lambda result: over(partial(np.percentile, q=50), result.planning_times)),
    "plan_time_ms_p99": (float, lambda result: over(partial(np.percentile, q=99), result.planning_times)),
}
"""Type and measure of each column of a trial; None where there is nothing to measure. Speeds in m/s; shares of the
control periods, 0 to 1."""
MEASURES = {name: kind for name, (kind, _) in MEASURED.items()} | {"wall_time_s": float, "error": str}
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
PATH_RATE, PATH_UNIT = 20.0, 1e-4
"""Points of a path per second [Hz], and what paths are kept in whole multiples of [m]."""

NO_PATH: dict[str, list[int]] = {"t_ms": [], "x": [], "y": []}
TABLE, PATHS, IMPACTS = "trials.parquet", "trajectories.parquet", "impacts.parquet"
PATH = {"t": ("t_ms", 1e-3), "x": ("x", PATH_UNIT), "y": ("y", PATH_UNIT)}
"""Columns of a path: the name of each in a record, and its unit there [s, m]."""

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
    """The measured columns of a trial that took `wall_time` [s]."""
    return {name: measure(result) for name, (_, measure) in MEASURED.items()} | {"wall_time_s": wall_time, "error": ""}


def error_measures(error: Exception) -> dict[str, Any]:
    """The measured columns of a trial that raised."""
    message = " ".join(f"{type(error).__name__}: {error}".split())
    return {**dict.fromkeys(MEASURES), "outcome": ERROR, "error": message}


def sampled_path(trajectory: np.ndarray) -> dict[str, list[int]]:
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


def write_tables(folder: Path, grid: Sequence[Task], records: Iterable[TrialRow]) -> None:
    """Writes the tables of a study from its records in the order of the grid."""
    names = columns(axes_of(list(grid[0].labels)))
    labels = {name: kind for name, kind in names.items() if name not in MEASURES}
    tables: dict[str, tuple[Mapping[str, Any], list[Any]]] = {
        TABLE: (names, []),
        PATHS: ({**labels, **dict.fromkeys(PATH, pl.List(pl.Float32))}, []),
        IMPACTS: ({**labels, **IMPACT}, []),
    }
    for record in records:
        row, path = record["row"], record["path"]
        of_labels = {name: row[name] for name in labels}
        tables[TABLE][1].append(row)
        points = {name: np.array(path[key], dtype=float) * unit for name, (key, unit) in PATH.items()}
        tables[PATHS][1].append(of_labels | {name: values.astype(np.float32) for name, values in points.items()})
        tables[IMPACTS][1].extend(of_labels | impact for impact in record["impacts"])
    for file, (kinds, rows) in tables.items():
        part = folder / f".{file}.part"
        pl.DataFrame(rows, schema=kinds, orient="row").write_parquet(part)
        os.replace(part, folder / file)
