"""runs/faults.json and docs/reliability.md, from the cases that were done."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

from faults.fault import Fault
from faults.runner import Case

FEWEST = 500
"""A 99th percentile of fewer cases would be the largest one under another name."""
LEVEL = 0.95
BEGIN, END = "<!-- stops: written by make faults -->", "<!-- end of stops -->"
"""Around the table in docs/safety.md."""
HEAD = """\
# Faults, and whether the robot stood in time

Each row is a fault done again and again to a robot that drives: what is done, the longest time allowed, and what came
of it. **Everything here is simulated**: the whole graph in processes with the simulated robot (`simulator`), the same
over serial bytes with the emulated firmware (`serial`), bringup and its runs (`bringup`, `process`), and the closed
loop without ROS (`trial`). The table is written by `make faults`, the cases are in `runs/faults/`, the figures as data
in `runs/faults.json`.

| column | |
|---|---|
| n | cases that count |
| misses | cases later than the limit, or in which the robot did what it must not |
| at most | upper end of the 95 % interval of the rate of misses, by Clopper and Pearson: 17 % for none in 20 |
| stalls | cases that do not count and were repeated: the machine itself stood still, see below |
| limit, median, p99, max | time until zero, of the side that must act, by its own clock [s]; p99 from 500 cases on |
| way | longest way from the fault until the robot was at rest [m], and the fastest it drove before |

A stall is told on the side that must act: by its own times of sending, it was silent for over 0.075 s where it sends
every 0.05 s. A row without times is one in which nothing may happen at all. How a fault is made, and from when to when
time is taken, stands in `tools/faults/`, a file a group. Doing it: `make faults` (20 of each), `make faults-long` (as
many as each row needs; `make faults-long ARGS="--minutes 30"` does a slice, and the next call goes on). Cases count as
long as nothing in `src/` changes.
What follows from it for people: [safety.md](safety.md).

"""


def figures(fault: Fault, cases: Sequence[Case]) -> dict[str, Any]:
    """The record of a fault in faults.json; times are null where there are none."""
    counted = [case for case in cases if case.counts]
    times = np.array([case.seconds for case in counted if case.seconds is not None])
    return {
        "fault": fault.name,
        "robot": fault.robot,
        "n": sum(case.n for case in counted),
        "misses": sum(bool(case.miss) for case in counted),
        "stalls": len(cases) - len(counted),
        "limit_s": fault.limit,
        "median_s": round(float(np.median(times)), 4) if len(times) else None,
        "p99_s": round(float(np.quantile(times, 0.99)), 4) if len(times) >= FEWEST else None,
        "max_s": round(float(times.max()), 4) if len(times) else None,
    }


def largest_rate(misses: int, n: int) -> float:
    """Upper end of the interval that holds the rate of misses with probability LEVEL, by Clopper and Pearson."""
    return float(binomtest(misses, n).proportion_ci(LEVEL, method="exact").high)


def write(faults: Sequence[Fault], cases: Sequence[Case], data: Path, page: Path, safety: Path | None = None) -> None:
    """Writes data, page, and the table of stops in the page `safety`, of the faults of which there are cases."""
    rows = [(fault, [case for case in cases if case.fault == fault.key]) for fault in faults]
    rows = [(fault, found) for fault, found in rows if any(case.counts for case in found)]
    records = [figures(fault, found) for fault, found in rows]
    data.parent.mkdir(parents=True, exist_ok=True)
    data.write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")
    lines = [_row(record, found) for record, (_, found) in zip(records, rows, strict=True)]
    names = "| fault | robot | n | misses | at most | stalls | limit | median | p99 | max | way |\n"
    page.write_text(HEAD + names + "|---" * 11 + "|\n" + "".join(lines), encoding="utf-8")
    if safety is not None:
        before, _, rest = safety.read_text(encoding="utf-8").partition(BEGIN)
        stops = "".join(_stop(record, found) for record, (_, found) in zip(records, rows, strict=True))
        table = "| what | robot | n | median [s] | max [s] | way [m] |\n" + "|---" * 6 + "|\n" + stops
        safety.write_text(f"{before}{BEGIN}\n{table}{END}{rest.partition(END)[2]}", encoding="utf-8")


def _stop(record: dict[str, Any], cases: Sequence[Case]) -> str:
    """Its line in the table of stops; empty where no way was measured."""
    way = _way(cases)
    figures = [record["fault"], record["robot"], record["n"], _shown(record["median_s"]), _shown(record["max_s"]), way]
    return "| " + " | ".join(map(str, figures)) + " |\n" if way else ""


def _way(cases: Sequence[Case]) -> str:
    moved = [case for case in cases if case.counts and case.distance is not None and case.speed is not None]
    return f"{max(c.distance for c in moved):.2f} from {max(c.speed for c in moved):.2f} m/s" if moved else ""


def _row(record: dict[str, Any], cases: Sequence[Case]) -> str:
    times = [_shown(record[key]) for key in ("limit_s", "median_s", "p99_s", "max_s")]
    rate = f"{100 * largest_rate(record['misses'], record['n']):.2g} %"
    figures = [
        record["fault"],
        record["robot"],
        record["n"],
        record["misses"],
        rate,
        record["stalls"],
        *times,
        _way(cases),
    ]
    return "| " + " | ".join(map(str, figures)) + " |\n"


def _shown(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.3g}"
