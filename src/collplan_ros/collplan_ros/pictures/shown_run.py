"""Reading a run folder for the animation beside other runs."""

import csv
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from collplan_ros.pictures.drawing import Marks, Trail, trail_of
from collplan_ros.runs.impact_log import impacts_of
from collplan_ros.runs.record_reading import Record
from collplan_ros.runs.recorded_run import RecordedRun, read_run
from collplan_ros.runs.run_error import RunError

IMPACT = ("t", "x", "y", "deliberate")


@dataclass(frozen=True, eq=False)
class ShownRun:
    """A run as it is shown; times count from the first non-zero command [s].

    Attributes:
        recorded: folder, settings and world of the run.
        trail: measured path of the robot.
        marks: impacts of the run.
        goal: (2,) [m].
        outcome: outcome of the run, with spaces for underscores.
    """

    recorded: RecordedRun
    trail: Trail
    marks: Marks
    goal: np.ndarray
    outcome: str

    @property
    def end(self) -> float:
        """Time of the last pose [s], at the goal if that was reached."""
        return float(self.trail.times[-1])


def read_shown_run(folder: Path) -> ShownRun:
    """Reads the run in a folder of bringup.

    Raises:
        RunError: a file is missing or has another form than bringup writes.
    """
    run = read_run(folder)
    if run.unfinished is not None:
        return _unfinished(run, run.unfinished)
    trail = trail_of(run.path.times, run.path.points, run.settings.robot.max_speed)
    goal, outcome = _end(folder / "summary.json")
    return ShownRun(run, trail, _marks(folder / "impacts.csv"), goal, outcome)


def _unfinished(run: RecordedRun, record: Record) -> ShownRun:
    """A run without results, as far as it was recorded."""
    log = record.log
    impacts = impacts_of(log, run.world, run.settings.mocap.velocity_window)
    trail = trail_of(run.path.times, run.path.points, run.settings.robot.max_speed)
    marks = Marks(impacts.times - log.begin, impacts.points, impacts.deliberate)
    return ShownRun(run, trail, marks, record.goal, "incomplete")


def _end(file: Path) -> tuple[np.ndarray, str]:
    """Goal (2,) [m] and outcome in a summary."""
    try:
        summary = json.loads(file.read_text())
        goal = np.array(summary["goal"], dtype=float).reshape(2)
        return goal, str(summary["outcome"]).replace("_", " ")
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise RunError(f"{file}: expected JSON with outcome, and goal [x, y]: {error!r}") from None


def _marks(file: Path) -> Marks:
    try:
        rows = csv.DictReader(file.read_text().splitlines())
    except (OSError, UnicodeDecodeError) as error:
        raise RunError(f"{file}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    missing = [column for column in IMPACT if column not in (rows.fieldnames or ())]
    if missing:
        raise RunError(f"{file}: no column {', '.join(missing)}, expected what bringup writes")
    read = [_mark(f"{file}, line {rows.line_num}", row) for row in rows]
    numbers = np.array([each[:3] for each in read]).reshape(-1, 3)
    return Marks(numbers[:, 0], numbers[:, 1:], np.array([each[3] for each in read], dtype=bool))


def _mark(where: str, row: dict[str, str]) -> tuple[float, float, float, bool]:
    def value(column: str, convert: Callable[[str], Any], expected: str) -> Any:
        try:
            return convert(row[column])
        except (KeyError, TypeError, ValueError):
            raise RunError(f"{where}, {column}: got {row[column]!r}, expected {expected}") from None

    t, x, y = (value(column, float, "a number") for column in IMPACT[:3])
    return t, x, y, value("deliberate", {"true": True, "false": False}.__getitem__, "true or false")
