"""runs/faults.json and the table in docs/reliability.md, from the cases that were done."""

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
"""Of the interval of the rate of misses, by Clopper and Pearson, whose upper end the table gives."""
ROWS = "<!-- faults: written by make faults -->", "<!-- end of faults -->"
"""Around the table in docs/reliability.md."""


def figures(fault: Fault, cases: Sequence[Case]) -> dict[str, Any]:
    """The record of a fault in faults.json; times are null where there are none."""
    counted = [case for case in cases if case.counts]
    times = np.array([case.seconds for case in counted if case.seconds is not None])
    return {
        "fault": fault.name,
        "robot": fault.robot,
        "n": sum(case.n for case in counted),
        "misses": sum(bool(case.miss) for case in counted),
        "stalls": sum(bool(case.stall) for case in cases),
        "limit_s": fault.limit,
        "median_s": round(float(np.median(times)), 4) if len(times) else None,
        "p99_s": round(float(np.quantile(times, 0.99)), 4) if len(times) >= FEWEST else None,
        "max_s": round(float(times.max()), 4) if len(times) else None,
    }


def write(faults: Sequence[Fault], cases: Sequence[Case], data: Path, page: Path) -> None:
    """Writes data, and the table in the page: rows of which there are cases, and all that `make faults` does."""
    rows = [(fault, [case for case in cases if case.fault == fault.key]) for fault in faults]
    rows = [(fault, found) for fault, found in rows if fault.short or any(case.counts for case in found)]
    records = [figures(fault, found) for fault, found in rows]
    data.parent.mkdir(parents=True, exist_ok=True)
    data.write_text(json.dumps(records, indent=1) + "\n", encoding="utf-8")
    lines = [_row(record, found) for record, (_, found) in zip(records, rows, strict=True)]
    names = "| fault | robot | n | misses | at most | stalls | limit | median | p99 | max | way |\n"
    _put(page, names + "|---" * 11 + "|\n" + "".join(lines))


def _put(page: Path, text: str) -> None:
    """Puts a text between the two marks of a page, or makes a page of it if there is none."""
    begin, end = ROWS
    before, _, rest = page.read_text(encoding="utf-8").partition(begin) if page.exists() else ("", "", "")
    page.write_text(f"{before}{begin}\n{text}{end}{rest.partition(end)[2]}", encoding="utf-8")


def _way(cases: Sequence[Case]) -> str:
    moved = [case for case in cases if case.counts and case.distance is not None and case.speed is not None]
    return f"{max(c.distance for c in moved):.2f} from {max(c.speed for c in moved):.2f} m/s" if moved else ""


def _row(record: dict[str, Any], cases: Sequence[Case]) -> str:
    times = [_shown(record[key]) for key in ("limit_s", "median_s", "p99_s", "max_s")]
    rate = ""
    if record["n"]:
        interval = binomtest(record["misses"], record["n"]).proportion_ci(LEVEL, method="exact")
        rate = f"{100 * interval.high:.2g} %"
    counts = [record[key] for key in ("fault", "robot", "n", "misses")]
    return "| " + " | ".join(map(str, [*counts, rate, record["stalls"], *times, _way(cases)])) + " |\n"


def _shown(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:.3g}"
