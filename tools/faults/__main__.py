"""Does every fault again and again to a robot that drives, and writes the table of docs/reliability.md.

What was done with the same sources counts: a run that was broken off goes on, and the long one goes on from it.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import conftest  # noqa: F401  a ROS domain of its own on this machine alone
from collplan_core.jit import sources_digest
from collplan_ros.bringup.ending import Interrupted
from faults import base, line, movers, simulator, trials
from faults.live_graph import LiveGraph
from faults.runner import Bench, BenchError, CaseFile, Fault, run_bench
from faults.table import write

# checks of message fields are for tests; nodes run without
os.environ.pop("ROS_PYTHON_CHECK_FIELDS", None)
ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "runs" / "faults"
FAULTS: list[Fault] = [fault for group in (simulator, trials, line, base, movers) for fault in group.FAULTS]
BENCHES: dict[str, Callable[[], Any]] = {
    "simulator": lambda: LiveGraph("sim"),
    "serial": lambda: LiveGraph("emulator"),
    "base": base.BaseGraph,
    "process": Bench,
    "trial": Bench,
}
"""By the robot of a row, in the order in which they are opened."""


def main() -> int:
    """Does what is to be done, and writes the table from all cases."""
    options = _parser().parse_args()
    deadline = time.monotonic() + 60.0 * options.minutes
    digests = (sources_digest(ROOT / part) for part in ("src", "tools/faults"))
    file = CaseFile(options.out / "cases.jsonl", "".join(digests))
    rows = [fault for fault in FAULTS if options.only in fault.key]
    failed = _do(rows, options, file, deadline)
    write(FAULTS, file, (ROOT / "docs" if options.out == CASES else options.out.parent) / "reliability.md")
    waiting = {fault.key: n for fault in rows if (n := _count(options, fault) - file.done(fault)) > 0}
    print("\n".join(f"{key}: {missing} to do" for key, missing in waiting.items()) or "all done")
    unfinished = waiting and time.monotonic() < deadline
    return 1 if failed or unfinished or any(case.missed for case in file.cases) else 0


def _count(options: argparse.Namespace, fault: Fault) -> int:
    """How many cases of a row are asked for."""
    return fault.long if options.long else options.n


def _do(rows: list[Fault], options: argparse.Namespace, file: CaseFile, deadline: float) -> bool:
    """Does what there is time for; whether a bench has failed."""
    failed = False
    for robot, open_bench in BENCHES.items():
        own = [fault for fault in rows if fault.robot == robot]
        try:
            for case in run_bench(own, open_bench, lambda fault: _count(options, fault), file, deadline):
                print(case, flush=True)
        except BenchError as error:
            failed = True
            print(f"{robot}: {error}", flush=True)
        except (Interrupted, KeyboardInterrupt):
            print("interrupted: the next call goes on", flush=True)
            return True
    return failed


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="make faults", description=__doc__)
    add = parser.add_argument
    add("--n", type=int, default=20, help="cases of each fault (default %(default)s)")
    add("--long", action="store_true", help="of each fault as many as its row needs")
    add("--minutes", type=float, default=1e9, help="a slice: ends after so long, and goes on when called again")
    add("--only", default="", metavar="TEXT", help="only faults with this in name or robot")
    add("--out", type=Path, default=CASES, metavar="DIR", help="where the cases go, and are read")
    return parser


if __name__ == "__main__":
    sys.exit(main())
