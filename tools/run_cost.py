"""What the recording costs, or the live page: runs with and without it in pairs, each in a process of its own.

CPU is of the time from goal to arrival, as a share of one core: of bringup's process, and of all of its nodes. The
control period is that of summary.json. The live page is open once, to a client that reads and draws nothing.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np

from view_load import PORT, Page

RUN = """
import json, os, sys, time
from pathlib import Path
from collplan_ros.bringup.main import Bringup
from collplan_ros.bringup.options import parse
from collplan_ros.bringup.results import write_results

def used(pids):
    fields = [Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split() for pid in pids]
    return sum(int(each[11]) + int(each[12]) for each in fields) / os.sysconf("SC_CLK_TCK")

options = parse(sys.argv[1:])
started = time.monotonic()
with Bringup(options) as bringup:
    bringup.graph.wait_until_ready()
    pids = bringup.graph.pids.values()
    own, nodes, begun = time.process_time(), used(pids), time.monotonic()
    outcome = bringup.drive()
    seconds = time.monotonic() - begun
    own, nodes = time.process_time() - own, used(pids) - nodes
    bringup.come_to_rest()
recorded = time.monotonic() - started
folder = bringup.folder
results = write_results(folder, bringup.read_log(), bringup.preparation, outcome, options)
print(json.dumps({
    "outcome": outcome, "seconds": seconds, "bringup": 100 * own / seconds, "nodes": 100 * nodes / seconds,
    "p50": results.summary["control_period_ms"]["p50"], "p99": results.summary["control_period_ms"]["p99"],
    "plan": results.summary["plan_time_ms"]["p50"], "load": os.getloadavg()[0],
    "bytes_per_second": folder.recording.stat().st_size / recorded if options.recording else 0.0,
}))
"""
WITHOUT = {"recording": ["--no-recording"], "page": []}
WITH = {"recording": [], "page": ["--view"]}
FIGURES = {
    "bringup": "bringup's CPU [% of a core]",
    "nodes": "CPU of all nodes [% of a core]",
    "p50": "control period, median [ms]",
    "p99": "control period, p99 [ms]",
    "plan": "planning time, median [ms]",
}


def measured(folder: Path, options: list[str]) -> dict[str, float]:
    """The figures of one run."""
    command = [sys.executable, "-c", RUN, "--no-pictures", "--out", str(folder), *options]
    end = threading.Event()
    page = Page(PORT, end)
    if "--view" in options:
        page.start()
    done = subprocess.run(command, capture_output=True, text=True, timeout=300.0)
    end.set()
    if done.returncode != 0:
        raise SystemExit(f"a run failed: {done.stderr[-2000:]}")
    if "--view" in options and not page.frames:
        raise SystemExit("the page was sent nothing")
    return json.loads(done.stdout.splitlines()[-1])


def main() -> int:
    """Prints the figures of pairs of runs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=WITH, help="whose cost")
    parser.add_argument("--pairs", type=int, default=20, metavar="N", help="so many (default 20)")
    parser.add_argument("--world", default="serpentine:2", metavar="W", help="where (default serpentine:2)")
    parser.add_argument("--strategy", default="bounce", metavar="NAME", help="how (default bounce)")
    given = parser.parse_args()
    pairs: list[dict[bool, dict[str, float]]] = []
    with tempfile.TemporaryDirectory(prefix="runs-") as folder:
        for pair in range(given.pairs):
            pairs.append({})
            for there in (True, False) if pair % 2 else (False, True):  # neither is always the first
                options = ["--world", given.world, "--strategy", given.strategy, "--seed", str(pair)]
                row = measured(Path(folder, str(there)), options + (WITH if there else WITHOUT)[given.part])
                pairs[-1][there] = row
                print(json.dumps({given.part: there, **row}), file=sys.stderr, flush=True)
    whole = [pair for pair in pairs if all(row["outcome"] == "reached" for row in pair.values())]
    print(f"{len(whole)} of {len(pairs)} pairs, both of which reached the goal, in {given.world} with {given.strategy}")
    if not whole:
        return 1
    print(f"{'median':<32} {'with':>8} {'without':>8} {'change':>8}")
    for name, words in FIGURES.items():
        each = [np.array([pair[there][name] for pair in whole]) for there in (True, False)]
        difference = each[0] - each[1]
        low, high = np.percentile(difference, [10, 90])
        medians = [*map(np.median, each), np.median(difference)]
        spread = f"(10 to 90 %: {low:+.2f} to {high:+.2f})"
        print(f"{words:<32} {medians[0]:8.2f} {medians[1]:8.2f} {medians[2]:+8.2f}  {spread}")
    size = 60e-6 * np.median([pair[True]["bytes_per_second"] for pair in whole])
    print(f"{'size of run.mcap [MB a minute]':<32} {size:8.2f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
