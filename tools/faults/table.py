"""The table in docs/reliability.md, from the cases that were done."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.stats import binomtest

from faults.runner import Case, CaseFile, Fault

FEWEST = 500
"""A 99th percentile of fewer cases would be the largest one under another name."""
LEVEL = 0.95
"""Of the interval of the rate of misses, by Clopper and Pearson, whose upper end the table gives."""
MARKS = "<!-- faults: written by make faults -->", "<!-- end of faults -->"
"""Around the table in docs/reliability.md."""
NAMES = ("fault", "robot", "n", "misses", "at most", "stalls", "limit", "median", "p99", "max", "way")


def write(faults: Sequence[Fault], file: CaseFile, page: Path) -> None:
    """Writes the table between the two marks of a page, which is made where there is none."""
    rows = [NAMES, ("---",) * len(NAMES), *(_cells(fault, file.of(fault)) for fault in faults)]
    table = (
        "".join("| " + " | ".join(cells) + " |\n" for cells in rows).replace("| ---", "|---").replace("--- |", "---|")
    )
    begin, end = MARKS
    before, _, rest = page.read_text(encoding="utf-8").partition(begin) if page.exists() else ("", "", "")
    page.write_text(f"{before}{begin}\n{table}{end}{rest.partition(end)[2]}", encoding="utf-8")


def _cells(fault: Fault, cases: Sequence[Case]) -> tuple[str, ...]:
    """The cells of a row; empty where there is no figure."""
    counted = [case for case in cases if case.counts]
    times = np.array([case.seconds for case in counted if case.seconds is not None])
    n, misses = len(counted), sum(bool(case.missed) for case in counted)
    rate = f"{100 * binomtest(misses, n).proportion_ci(LEVEL, method='exact').high:.2g} %" if n else ""
    levels = (0.5, 0.99 if len(times) >= FEWEST else None, 1.0)
    found = [_shown(float(np.quantile(times, level)) if level and len(times) else None) for level in levels]
    moved = [(case.distance, case.speed) for case in counted if case.distance is not None and case.speed is not None]
    way = "{:.2f} from {:.2f} m/s".format(*(max(each) for each in zip(*moved, strict=True))) if moved else ""
    stalls = str(sum(bool(case.stalled) for case in cases))
    return (fault.name, fault.robot, str(n), str(misses), rate, stalls, _shown(fault.limit), *found, way)


def _shown(seconds: float | None) -> str:
    return "" if seconds is None else f"{round(seconds, 4):.3g}"
