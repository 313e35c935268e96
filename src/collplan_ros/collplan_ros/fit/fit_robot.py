"""The program fit_robot: drive and rebound of the robot from recorded runs, written to a parameter file."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from collplan_core.calibration.drive_fit import FEWEST_SECONDS
from collplan_core.calibration.fitted_constant import TooLittle, Unexplained
from collplan_core.calibration.impact_fit import FAR
from collplan_core.calibration.rebound_fit import FEWEST, FEWEST_SLIDING
from collplan_core.calibration.wall_impacts import SLOWEST, SLOWEST_SLIP
from collplan_core.command_line import parser_of
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.parameters.spec import ParameterError
from collplan_ros.fit.fitting import RobotFit, believed_otherwise, fit_robot, hits_found
from collplan_ros.fit.recorded_impacts import FARTHEST_WALL
from collplan_ros.fit.recorded_path import FittedRun, fitted_run
from collplan_ros.run.description import RUN
from collplan_ros.run.reader import description
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.simulated_drive import same_simulated_drive
from collplan_ros.run.whole_file import RunError
from collplan_ros.run.writer import RECORDING

REFUSED = 2
"""Exit code of a fit that is not possible."""

DESCRIPTION = f"""\
Estimates the robot's constants, each with a 95 % interval, from the poses and commands that bringup recorded, and
writes them into a ROS parameter file:

  robot.max_acceleration  largest acceleration of the wheels  {FEWEST_SECONDS:g} s away from walls, with commands
  robot.velocity_lag      time constant of the velocity loop  that change by 1 m/s and more
  rebound.restitution     share of the speed into a wall that {FEWEST} hits at least, at different speeds above
                          comes back                          {SLOWEST:g} m/s into a wall
  rebound.friction        Coulomb friction of ring and wall   {FEWEST} hits at least above {SLOWEST_SLIP:g} m/s along a
                                                              wall, sliding at {FEWEST_SLIDING} of them: a grazing angle

The drive is fitted first; the fit then gives the wheels' motion around each hit, whatever drive parameters the runs
used. A parameter of the runs outside the fitted interval is reported. Hits are detected again in the poses. A hit
counts where no other one is within {FAR:g} s and a surface of the run's world is within {1e2 * FARTHEST_WALL:g} cm of
the robot's rim. robot.radius may be off by 5 mm. robot.inertia_factor must be right: it decides which hits slide. From
simulated runs the new file also holds simulator.mass_ratio and simulator.acceleration_ratio, which keep the simulated
robot the same.

Written: exit code 0. Poses that no drive explains, runs of robots of different radius, too few or too similar hits, or
a request that cannot be fulfilled: 2, and nothing is written.
"""
EPILOG = """\
examples:
  fit_robot runs/latest
  fit_robot runs/2026-* --params checked.yaml --out fitted.yaml
      checked.yaml with the constants found, into fitted.yaml
  bringup --params fitted.yaml
      drives with it
"""


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    options = _parser().parse_args(args)
    try:
        _fit(options)
    except (RunError, TooLittle, Unexplained, ParameterError) as error:
        print(f"fit_robot: {error}", file=sys.stderr)
        return REFUSED
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = parser_of("fit_robot", DESCRIPTION, EPILOG)
    add = parser.add_argument
    add("runs", type=Path, nargs="+", metavar="RUN", help="run folder of bringup; one given twice counts once")
    add("--params", type=Path, metavar="FILE", help="ROS parameter file whose other values the new file takes over")
    add("--out", type=Path, default=Path("robot.yaml"), metavar="FILE", help="new file (default robot.yaml)")
    add("--force", action="store_true", help="replace that file if there is one")
    return parser


def _fit(options: argparse.Namespace) -> None:
    if options.out.exists() and not options.force:
        raise RunError(f"--out {options.out}: exists, expected a new file; --force replaces it")
    runs = _read(options.runs)
    namespace = description(options.runs[0] / RECORDING, RUN).get("namespace", "/")
    given = read_parameters(options.params, namespace) if options.params else {}
    _check_radius(given, options.params, runs)
    fit = fit_robot(runs)
    print(hits_found(runs, fit.usable, fit.left_out))
    print(_table(fit))
    notes = [*believed_otherwise(fit, runs), *([fit.rebound.warning] if fit.rebound.warning else [])]
    for note in notes:
        print(f"note: {note}")
    _write(options.out, given, fit, runs, notes)
    print(f"written to {options.out}: drive with --params {options.out}")


def _read(folders: Sequence[Path]) -> list[FittedRun]:
    """Reads each run once, also where the link `latest` names a folder again."""
    read = [read_run(folder) for folder in dict.fromkeys(folder.resolve() for folder in folders)]
    runs = [fitted_run(run) for run in read]
    for note in filter(None, (run.note for run in read)):
        print(f"note: {note}")
    kinds = {run.simulated: run.name for run in runs}
    if len(kinds) > 1:
        raise RunError(f"got the simulated run {kinds[True]} and the real run {kinds[False]}, expected one kind")
    return runs


def _check_radius(given: dict[str, object], file: Path | None, runs: Sequence[FittedRun]) -> None:
    radius = given.get("robot.radius")
    for run in runs:
        if radius not in (None, run.settings.robot.radius):
            raise RunError(
                f"robot.radius: {run.name} was driven with {run.settings.robot.radius:g} m, expected the {radius:g} "
                f"m of --params {file}"
            )


def _table(fit: RobotFit) -> str:
    lines = [f"{'':<24}value    95 % interval      from"]
    for key, found in fit.constants.items():
        interval = f"{found.low:.4f} to {found.high:.4f}"
        lines.append(f"{key:<24}{found.value:.4f}   {interval:<18} {found.basis}")
    return "\n".join(lines)


def _write(
    path: Path, given: dict[str, object], fit: RobotFit, runs: Sequence[FittedRun], notes: Sequence[str]
) -> None:
    found: dict[str, object] = {key: round(constant.value, 4) for key, constant in fit.constants.items()}
    kind = "simulated" if runs[0].simulated else "real"
    if runs[0].simulated:
        drive = fit.drive.max_acceleration.value, fit.drive.velocity_lag.value
        found |= same_simulated_drive(*drive, runs[0].settings)
    folders = "\n".join(run.name for run in runs)
    comment = "\n\n".join((f"fit_robot, {kind} runs:\n{folders}", _table(fit), *notes))
    try:
        write_values({**given, **found}, path, comment)
    except OSError as error:
        raise RunError(f"--out {path}: cannot be written: {error.strerror or error}") from None


if __name__ == "__main__":
    sys.exit(main())
