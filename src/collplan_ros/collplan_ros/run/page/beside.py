"""The program beside: puts recorded runs on one page, which plays them on one clock."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from collplan_core.command_line import parser_of
from collplan_ros.run.page.run_page import write_page
from collplan_ros.run.recorded_run import RecordedRun, read_run
from collplan_ros.run.result_files import complete
from collplan_ros.run.whole_file import RecordError, RunError

REFUSED = 2
"""Exit code of a request that cannot be fulfilled."""

DESCRIPTION = """\
Puts runs that bringup recorded in one world on one page like run.html. It plays them in a browser on one clock, which
is zero at each run's first command to move. A click on a picture shows that run at the side.

Written: exit code 0. A request that cannot be fulfilled: 2, and no page is written.
"""
EPILOG = """\
examples:
  bringup --world serpentine:3 --strategy avoid --out runs/avoid
  bringup --world serpentine:3 --strategy bounce --out runs/bounce
  beside runs/avoid/latest runs/bounce/latest
"""


def main(args: Sequence[str] | None = None) -> int:
    """Entry point of the executable; returns its exit code."""
    options = _parser().parse_args(args)
    try:
        made = [report for report in map(complete, options.runs) if report]
        runs = _runs(options.runs)
        write_page(options.out, runs)
    except (RecordError, RunError) as error:
        print(f"beside: {error}", file=sys.stderr)
        return REFUSED
    print("\n".join([*made, f"written to {options.out}", *(run.note for run in runs if run.note)]))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = parser_of("beside", DESCRIPTION, EPILOG)
    add = parser.add_argument
    add("runs", type=Path, nargs="+", metavar="RUN", help="run folders of bringup, at least two")
    add("--out", type=Path, default=Path("beside.html"), metavar="FILE", help="page written (default beside.html)")
    return parser


def _runs(folders: Sequence[Path]) -> list[RecordedRun]:
    if len(folders) < 2:
        raise RunError(f"got {len(folders)} run, expected at least two to show beside each other")
    runs = [read_run(folder) for folder in folders]
    worlds = dict.fromkeys(run.settings.simulator.world for run in runs)
    if len(worlds) > 1:
        raise RunError(f"got runs in the worlds {', '.join(worlds)}, expected one world")
    return runs


if __name__ == "__main__":
    sys.exit(main())
