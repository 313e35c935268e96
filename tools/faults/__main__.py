"""Does every fault again and again to a robot that drives; writes runs/faults.json and docs/reliability.md.

What was done with the same sources counts: a run that was broken off goes on, and the long one goes on from it.
"""

import argparse
import os
import sys
import time
from collections.abc import Iterable
from multiprocessing import get_context
from pathlib import Path

import conftest  # noqa: F401  a ROS domain of its own on this machine alone
from collplan_core.jit import sources_digest
from collplan_ros.bringup.failures import Interrupted
from faults.bench import BenchError
from faults.rows import ASIDE, BENCHES, FAULTS
from faults.runner import Case, CaseFile, run_bench
from faults.table import write

# checks of message fields are for tests; nodes run without
os.environ.pop("ROS_PYTHON_CHECK_FIELDS", None)
ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
CASES = ROOT / "runs" / "faults"


def main() -> int:
    """Does what is to be done, the trials in a second process, and writes pages and data from all cases."""
    options = _parser().parse_args()
    deadline = time.monotonic() + 60.0 * options.minutes
    failed = False if options.list else _both(options, deadline)
    file = _case_file(options.out)
    data = options.out.parent / "faults.json"
    write(FAULTS, file.cases, data, (DOCS if options.out == CASES else options.out.parent) / "reliability.md")
    count = _counts(options)
    waiting = {key: n for fault in FAULTS if (n := count[(key := fault.key)] - file.done(fault)) > 0}
    print("\n".join(f"{key}: {missing} to do" for key, missing in waiting.items()) or "all done")
    is_over = options.list or time.monotonic() >= deadline
    return 1 if failed or any(case.miss for case in file.cases) or (waiting and not is_over) else 0


def _case_file(folder: Path) -> CaseFile:
    """The cases of this state of the code."""
    return CaseFile(folder / "cases.jsonl", "".join(sources_digest(ROOT / part) for part in ("src", "tools/faults")))


def _counts(options: argparse.Namespace) -> dict[str, int]:
    """How many cases of each row are asked for."""
    asked = {fault.key: fault.long if options.long else min(options.n, fault.short) for fault in FAULTS}
    return {key: n if options.only in key else 0 for key, n in asked.items()}


def _both(options: argparse.Namespace, deadline: float) -> bool:
    """Does the rows of all benches; whether a bench has failed."""
    aside = get_context("fork").Process(target=_do_aside, args=(options, deadline))
    aside.start()
    failed = _do([robot for robot in BENCHES if robot not in ASIDE], options, deadline)
    aside.join()
    return failed or aside.exitcode != 0


def _do_aside(options: argparse.Namespace, deadline: float) -> None:
    os.nice(19)
    sys.exit(_do(ASIDE, options, deadline))


def _do(robots: Iterable[str], options: argparse.Namespace, deadline: float) -> bool:
    """Does what there is time for; whether a bench has failed."""
    file, counts, failed = _case_file(options.out), _counts(options), False
    for robot in robots:
        rows = [fault for fault in FAULTS if fault.robot == robot]
        try:
            for case in run_bench(rows, BENCHES[robot], lambda fault: counts[fault.key], file, deadline):
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
    add("--n", type=int, default=20, help="cases of each fault (default %(default)s)")
    add("--long", action="store_true", help="of each fault as many as its row needs, and the rows that only this does")
    add("--minutes", type=float, default=1e9, help="a slice: ends after so long, and goes on when called again")
    add("--only", default="", metavar="TEXT", help="only faults with this in name or robot")
    add("--out", type=Path, default=CASES, metavar="DIR", help="where the cases go, and are read")
    add("--list", action="store_true", help="do nothing; say what there is to do, and write the table")
    return parser


if __name__ == "__main__":
    sys.exit(main())
