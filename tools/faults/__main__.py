"""Does every fault again and again to a robot that drives; writes runs/faults.json and docs/reliability.md.

What was done with the same sources counts: a run that was broken off goes on, and the long one goes on from it.
"""

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import conftest  # noqa: F401  a ROS domain of its own on this machine alone
from collplan_core.jit import sources_digest
from collplan_ros.bringup.failures import Interrupted
from faults.bench import BenchError
from faults.fault import Fault
from faults.rows import BENCHES, FAULTS
from faults.runner import Case, CaseFile, run_bench
from faults.table import N, seconds_taken, write

# checks of message fields are for tests; nodes run without
os.environ.pop("ROS_PYTHON_CHECK_FIELDS", None)
ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
CASES = ROOT / "runs" / "faults"


def main() -> int:
    options = _parser().parse_args()
    code = "".join(sources_digest(ROOT / folder) for folder in ("src", "tools/faults"))
    file = CaseFile(options.out / "cases.jsonl", code)
    chosen = [fault for fault in FAULTS if options.only in fault.key]
    end = time.monotonic() + 60.0 * options.minutes

    def count(fault: Fault) -> int:
        return fault.long if options.long else min(options.n, fault.short)

    failed = _done(chosen, count, file, end, options.list)
    data = options.out.parent / "faults.json"
    if options.out == CASES:
        write(FAULTS, file.cases, data, DOCS / "reliability.md", DOCS / "safety.md")
    else:
        write(FAULTS, file.cases, data, options.out.parent / "reliability.md")
    waiting = {fault.key: count(fault) - file.done(fault) for fault in chosen if file.done(fault) < count(fault)}
    print("\n".join(f"{key}: {missing} to do" for key, missing in waiting.items()) or "all done")
    print(f"the first {N} of each row took {seconds_taken(FAULTS, file.cases) / 60.0:.1f} minutes")
    is_over = options.list or time.monotonic() >= end
    return 1 if failed or any(case.miss for case in file.cases) or (waiting and not is_over) else 0


def _done(faults: list[Fault], count: Callable[[Fault], int], file: CaseFile, end: float, listed: bool) -> bool:
    """Does what there is time for; whether a bench has failed."""
    failed = False
    for robot, open_bench in {} if listed else BENCHES.items():
        try:
            for case in run_bench([f for f in faults if f.robot == robot], open_bench, count, file, end):
                print(said(case), flush=True)
        except BenchError as error:
            failed = True
            print(f"{robot}: {error}", flush=True)
        except (Interrupted, KeyboardInterrupt):
            print("interrupted: the next call goes on", flush=True)
            return True
    return failed


def said(case: Case) -> str:
    """A case in a line."""
    repeated = f"stalled, {case.stall}" if case.stall else f"not begun, {case.unbegun}" if case.unbegun else ""
    word = f"MISSED {case.miss}" if case.miss else repeated or "ok"
    seconds = "" if case.seconds is None else f" {case.seconds:.3f} s"
    way = "" if case.distance is None or case.speed is None else f", {case.distance:.2f} m from {case.speed:.2f} m/s"
    return f"{case.fault}:{seconds} {word}{way} ({case.took:.1f} s)"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="make faults", description=__doc__)
    add = parser.add_argument
    add("--n", type=int, default=N, help=f"cases of each fault (default {N})")
    add("--long", action="store_true", help="of each fault as many as its row needs, and the rows that only this does")
    add("--minutes", type=float, default=1e9, help="a slice: ends after so long, and goes on when called again")
    add("--only", default="", metavar="TEXT", help="only faults with this in name or robot")
    add("--out", type=Path, default=CASES, metavar="DIR", help="where the cases go, and are read")
    add("--list", action="store_true", help="do nothing; say what there is to do, and write the table")
    return parser


if __name__ == "__main__":
    sys.exit(main())
