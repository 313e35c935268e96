"""The program fit_rebound: restitution and tangential retention from recorded runs, written to a parameter file."""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from collplan_core.calibration.impact_fit import FAR
from collplan_core.calibration.rebound_fit import FEWEST, FittedConstant, ReboundFit, TooLittle, fit_rebound
from collplan_core.calibration.wall_impacts import ALONG, INTO, SLOWEST
from collplan_core.command_line import examples
from collplan_core.parameters.file import read_parameters, write_values
from collplan_core.parameters.spec import ParameterError
from collplan_ros.runs.recorded_impacts import measured_impacts
from collplan_ros.runs.recorded_run import RecordedRun, RunError, read_run

REFUSED = 2
"""Exit code of a fit that is not possible."""

DESCRIPTION = f"""\
Estimates how the robot rebounds, from the poses and commands that bringup recorded: restitution, the share of the
speed into a wall that comes back, and tangential retention, the share of the speed along it that is kept. Writes
both into a ROS parameter file.

Hits are found again in the poses. Those count that have no other one within {FAR:g} s and a surface of the run's world
at the robot's rim. Either constant needs {FEWEST} of them at different speeds, the restitution above
{SLOWEST[INTO]:g} m/s into a wall, the retention above {SLOWEST[ALONG]:g} m/s along it. robot.velocity_lag and
robot.max_acceleration of the runs must be the robot's own: they tell what the wheels did around a hit.

Written: exit code 0. Too few or too similar hits, or something asked for cannot be done: 2, and nothing is written.
"""
EPILOG = """\
examples:
  fit_rebound runs/latest
  fit_rebound runs/2026-* --params checked.yaml --out lab.yaml
      checked.yaml with the rebound found, into lab.yaml
  bringup --params lab.yaml
      drives with it
"""


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    options = _parser().parse_args(args)
    try:
        _fit(options)
    except (RunError, TooLittle, ParameterError) as error:
        print(f"fit_rebound: {error}", file=sys.stderr)
        return REFUSED
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="fit_rebound",
        description=DESCRIPTION,
        epilog=examples(EPILOG),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("runs", type=Path, nargs="+", metavar="RUN", help="run folder of bringup; the same one given twice counts once")
    add("--params", type=Path, metavar="FILE", help="ROS parameter file whose other values the new file takes over")
    add("--out", type=Path, default=Path("rebound.yaml"), metavar="FILE", help="new file (default rebound.yaml)")
    add("--force", action="store_true", help="replace that file if there is one")
    return parser


def _fit(options: argparse.Namespace) -> None:
    given = read_parameters(options.params) if options.params else {}
    if options.out.exists() and not options.force:
        raise RunError(f"--out {options.out}: exists, expected a new file; --force replaces it")
    runs = _read(options.runs)
    impacts, left_out = measured_impacts(runs)
    _print_impacts(runs, len(impacts), left_out)
    fit = fit_rebound(impacts)
    print(_table(fit))
    _write(options.out, given, fit, runs)
    print(f"written to {options.out}: drive with --params {options.out}")


def _read(folders: Sequence[Path]) -> list[RecordedRun]:
    """Reads each run once, also where the link `latest` names a folder again."""
    runs = [read_run(folder) for folder in dict.fromkeys(folder.resolve() for folder in folders)]
    kinds = {run.simulated: run.folder for run in runs}
    if len(kinds) > 1:
        raise RunError(f"got the simulated run {kinds[True]} and the real run {kinds[False]}, expected one kind")
    return runs


def _kind(runs: Sequence[RecordedRun]) -> str:
    return "simulated" if runs[0].simulated else "real"


def _print_impacts(runs: Sequence[RecordedRun], usable: int, left_out: Counter[str]) -> None:
    of_runs = f"{len(runs)} {_kind(runs)} run{'s' if len(runs) > 1 else ''}"
    print(f"hits found in {of_runs}: {usable + left_out.total()}, usable: {usable}")
    for reason, count in left_out.most_common():
        print(f"  left out: {count:3}  {reason}")


def _table(fit: ReboundFit) -> str:
    def row(name: str, e: FittedConstant) -> str:
        interval = f"{e.low:.3f} to {e.high:.3f}"
        return f"{name:<22}{e.value:.3f}   {interval}{e.impacts:7}   {e.slowest:.2f} to {e.fastest:.2f}"

    return "\n".join(
        (
            f"{'':<22}value   95 % interval    hits   speed before [m/s]",
            row("restitution", fit.restitution),
            row("tangential_retention", fit.tangential_retention),
        )
    )


def _write(path: Path, given: dict[str, object], fit: ReboundFit, runs: Sequence[RecordedRun]) -> None:
    found = {
        "rebound.restitution": round(fit.restitution.value, 4),
        "rebound.tangential_retention": round(fit.tangential_retention.value, 4),
    }
    folders = "\n".join(str(run.folder) for run in runs)
    try:
        write_values({**given, **found}, path, f"fit_rebound, {_kind(runs)} runs:\n{folders}\n\n{_table(fit)}")
    except OSError as error:
        raise RunError(f"--out {path}: cannot be written: {error.strerror or error}") from None


if __name__ == "__main__":
    sys.exit(main())
