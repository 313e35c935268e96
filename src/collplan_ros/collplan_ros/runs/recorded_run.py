"""Reading a run folder of bringup: measured poses and commands."""

import csv
import io
import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import collplan_core.planners  # noqa: F401  (registers what a run may have been planned by)
from collplan_core.calibration.impact_fit import RecordedPath
from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters
from collplan_core.parameters.spec import ParameterError
from collplan_core.plane import rotate_rows
from collplan_core.worlds import World, WorldError
from collplan_ros.recording.recorded_world import recorded_world
from collplan_ros.runs.record_reading import RECORD, Record, read_record
from collplan_ros.runs.run_error import RunError
from collplan_ros.runs.trajectory_file import write_trajectory_rows

MEASURED = ("t", "x", "y", "yaw")
COMMANDED = ("cmd_vx", "cmd_vy")


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """A run read from its folder.

    Attributes:
        folder: the run folder.
        simulated: whether the robot was simulated.
        settings: the parameters used.
        world: the world that the robot was in.
        path: poses and commands; t counts from the first non-zero command.
        yaws: (n,) measured yaw at each pose, without leaps of a turn [rad].
        unfinished: the record of a run that bringup did not live to write its files of, and that these were read from.
    """

    folder: Path
    simulated: bool
    settings: Settings
    world: World
    path: RecordedPath
    yaws: np.ndarray
    unfinished: Record | None = None

    @property
    def note(self) -> str:
        """What to tell of the run; "" where it is complete."""
        if self.unfinished is None:
            return ""
        end = f"{self.path.times[-1]:.2f} s"
        return f"{self.folder}: incomplete, bringup ended before the run did; {RECORD} holds it up to {end}"


def read_run(folder: Path) -> RecordedRun:
    """Reads the run in a folder.

    Raises:
        RunError: a file is missing or has another form than bringup writes.
    """
    settings, world = settings_and_world(folder)
    record = unfinished(folder)
    if record is not None:
        path, yaws = _path(folder / RECORD, _trajectory_of(record))
        return RecordedRun(folder, record.simulated, settings, world, path, yaws, record)
    trajectory = folder / "trajectory.csv"
    path, yaws = _path(trajectory, _text(trajectory))
    return RecordedRun(folder, _simulated(folder / "summary.json"), settings, world, path, yaws)


def settings_and_world(folder: Path) -> tuple[Settings, World]:
    """Parameters and world of the run in a folder.

    Raises:
        RunError: a file is missing or has another form than bringup writes.
    """
    if not folder.is_dir():
        raise RunError(f"{folder}: not a folder, expected one that bringup left")
    parameters = folder / "parameters.yaml"
    try:
        settings = Settings().with_values(read_parameters(parameters))
        return settings, recorded_world(folder, settings)
    except ParameterError as error:  # names the file
        raise RunError(str(error)) from None
    except (WorldError, OSError) as error:
        raise RunError(f"{parameters}: simulator.world: {error}") from None


def unfinished(folder: Path) -> Record | None:
    """The record, without plans and scans, of a run without results; None where there is none or they are there.

    The summary is the last of the results that readers need.

    Raises:
        RunError: the record is not as bringup writes it.
    """
    if (folder / "summary.json").exists() or not (folder / RECORD).exists():
        return None
    try:
        return read_record(folder / RECORD, pictured=False)
    except (OSError, LookupError, TypeError, ValueError) as error:
        raise RunError(f"{folder / RECORD}: expected what bringup writes: {error!r}") from None


def _trajectory_of(record: Record) -> str:
    rows = io.StringIO()
    write_trajectory_rows(rows, record.log)
    return rows.getvalue()


def _simulated(path: Path) -> bool:
    try:
        simulated = json.loads(_text(path))["simulated"]
    except (ValueError, KeyError, TypeError) as error:
        if isinstance(error, RunError):
            raise
        raise RunError(f"{path}: expected JSON with a key simulated, true or false") from None
    if not isinstance(simulated, bool):
        raise RunError(f"{path}: simulated: got {simulated!r}, expected true or false")
    return simulated


def _text(path: Path) -> str:
    try:
        return path.read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise RunError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None


def _path(file: Path, text: str) -> tuple[RecordedPath, np.ndarray]:
    """Poses with commands, and yaws (n,) [rad], in the text of a trajectory."""
    rows = csv.DictReader(text.splitlines())
    missing = [column for column in (*MEASURED, *COMMANDED) if column not in (rows.fieldnames or ())]
    if missing:
        raise RunError(f"{file}: no column {', '.join(missing)}, expected what bringup writes")
    numbers = np.array([_numbers(f"{file}, line {rows.line_num}", row) for row in rows]).reshape(-1, 6)
    if len(numbers) == 0:
        raise RunError(f"{file}: no poses, expected those of a run")
    falls = np.flatnonzero(np.diff(numbers[:, 0]) <= 0.0)
    if len(falls):
        line, (before, after) = falls[0] + 3, numbers[falls[0] : falls[0] + 2, 0]
        raise RunError(f"{file}, line {line}, t: got {after:g} after {before:g}, expected times that rise")
    path = RecordedPath(numbers[:, 0], numbers[:, 1:3], rotate_rows(numbers[:, 4:6], numbers[:, 3]))
    return path, np.unwrap(numbers[:, 3])


def _numbers(where: str, row: dict[str, str]) -> list[float]:
    measured = [_number(f"{where}, {column}", row[column]) for column in MEASURED]
    # before the first command the columns are nan
    return measured + [0.0 if row[c] == "nan" else _number(f"{where}, {c}", row[c]) for c in COMMANDED]


def _number(where: str, text: str | None) -> float:
    try:
        number = float(text or "")
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise RunError(f"{where}: got {text!r}, expected a finite number")
    return number
