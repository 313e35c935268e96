"""The program beside: animates recorded runs beside each other."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from collplan_core.command_line import examples
from collplan_ros.pictures.shown_run import ShownRun, read_shown_run
from collplan_ros.pictures.side_by_side import draw_side_by_side
from collplan_ros.runs.run_error import RunError

REFUSED = 2
"""Exit code of a request that cannot be fulfilled."""
SLOWEST, FASTEST = 0.05, 20.0
"""Limits of --speed."""

DESCRIPTION = """\
Animates runs that bringup recorded in one world beside each other, at the same time scale: each begins with its first
command to move, and its clock stops at the goal. Where the robot was measured is colored by speed; a disc marks a
deliberate contact, a cross any other.

Written: exit code 0. Something asked for cannot be done: 2, and nothing is written.
"""
EPILOG = """\
examples:
  bringup --world serpentine:3 --strategy avoid --out runs/avoid
  bringup --world serpentine:3 --strategy bounce --out runs/bounce
  beside runs/avoid/latest runs/bounce/latest --speed 0.5
"""


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    options = _parser().parse_args(args)
    try:
        runs = _runs(options.runs)
        for note in filter(None, (run.recorded.note for run in runs)):
            print(f"note: {note}")
        draw_side_by_side(options.out, runs, options.speed)
    except RunError as error:
        return _refused(str(error))
    except OSError as error:
        return _refused(f"--out {options.out}: cannot be written: {error.strerror or error}")
    print(f"written to {options.out}")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="beside",
        description=DESCRIPTION,
        epilog=examples(EPILOG),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("runs", type=Path, nargs="+", metavar="RUN", help="run folders of bringup, at least two")
    add("--out", type=_gif, default=Path("beside.gif"), metavar="FILE", help="GIF written (default beside.gif)")
    add("--speed", type=_speed, default=1.0, metavar="X", help="so many times real time (default 1)")
    return parser


def _gif(text: str) -> Path:
    if Path(text).suffix.lower() != ".gif":
        raise argparse.ArgumentTypeError(f"got {text}, expected a name that ends in .gif")
    return Path(text)


def _speed(text: str) -> float:
    try:
        speed = float(text)
    except ValueError:
        speed = 0.0
    if not SLOWEST <= speed <= FASTEST:
        raise argparse.ArgumentTypeError(f"got {text}, expected a number from {SLOWEST:g} to {FASTEST:g}")
    return speed


def _runs(folders: Sequence[Path]) -> list[ShownRun]:
    if len(folders) < 2:
        raise RunError(f"got {len(folders)} run, expected at least two to show beside each other")
    runs = [read_shown_run(folder) for folder in folders]
    worlds = dict.fromkeys(run.recorded.settings.simulator.world for run in runs)
    if len(worlds) > 1:
        raise RunError(f"got runs in the worlds {', '.join(worlds)}, expected one world")
    return runs


def _refused(message: str) -> int:
    print(f"beside: {message}", file=sys.stderr)
    return REFUSED


if __name__ == "__main__":
    sys.exit(main())
