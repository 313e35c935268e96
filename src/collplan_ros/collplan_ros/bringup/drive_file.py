"""The parameter file of `bringup --keep`, to which the drive that was learnt is written."""

from collections.abc import Mapping
from pathlib import Path

from collplan_core.learning.drive import DRIVE as LEARNS
from collplan_core.parameters import Settings, all_specs
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.parameters.spec import ParameterError
from collplan_ros.bringup.failures import StartError
from collplan_ros.messages.status_values import DRIVE
from collplan_ros.run.simulated_drive import same_simulated_drive
from collplan_ros.run.whole_file import RecordError, replacing


def check_keep(path: Path, settings: Settings) -> None:
    """Refuses what could not be written at the end of a run.

    Raises:
        StartError: nothing is learnt in this run, or the file or its folder cannot be used.
    """
    if settings.robot.learning != LEARNS:
        raise StartError(f"--keep {path}: robot.learning is {settings.robot.learning}, expected {LEARNS}")
    if not path.parent.is_dir():
        raise StartError(f"--keep {path}: {path.parent} is no folder")
    try:
        _held(path)
    except (ParameterError, OSError) as error:
        raise StartError(f"--keep: {error}") from None


def kept(path: Path, drive: Mapping[str, float], settings: Settings, simulated: bool) -> str:
    """Writes what was learnt, and is in use in the place of what is set, beside what the file holds.

    Args:
        drive: the figures of controller/drive.
        settings: those of the run; simulated: whether its robot was.

    Returns:
        a report for the terminal.
    """
    learnt = {f"robot.{name}": float(f"{drive[name]:.4g}") for name in DRIVE if f"{name}.learnt" in drive}
    learnt = {key: value for key, value in learnt.items() if value != settings.values()[key]}
    if not learnt:
        return f"{path}: not written, nothing was learnt that is not set"
    try:
        used = settings.with_values(learnt)
        robot, ratios = used.robot, dict[str, float]()
        if simulated:
            # they are ratios to what is believed: without others the simulated robot would become another one
            ratios = same_simulated_drive(robot.max_acceleration, robot.velocity_lag, settings)
            used.with_values(ratios)
        comment = f"Learnt while driving: {', '.join(learnt)}."
        with replacing(path) as unfinished:
            write_values({**_held(path), **learnt, **ratios}, unfinished, comment)
    except (ParameterError, RecordError, OSError) as error:
        return f"{path}: not written: {error}"
    units = {key: all_specs()[key].unit for key in learnt}
    return f"{path} now has what was learnt: " + ", ".join(f"{key} {learnt[key]:g} {units[key]}" for key in learnt)


def _held(path: Path) -> dict[str, object]:
    return read_parameters(path) if path.exists() and path.stat().st_size else {}
