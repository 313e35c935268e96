"""Every fault of some robots once, on graphs that are shared."""

import math
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from faults.rows import BENCHES, FAULTS
from faults.runner import CaseFile, run_bench

TRIES = (1, 3)
"""Cases of a row; then of one that was missed: a busy machine misses once, a defect again."""


def wrong_of(robots: Iterable[str], folder: Path) -> list[str]:
    """What has not come out as it must, of each row of `make faults`."""
    wrong = []
    for robot in robots:
        rows = [fault for fault in FAULTS if fault.robot == robot and fault.short]
        file = CaseFile(folder / f"{robot}.jsonl")
        for tries in TRIES:
            missed = Counter(case.fault for case in file.cases if case.miss)
            again = [fault for fault in rows if missed[fault.key] or not file.done(fault)]
            for case in run_bench(again, BENCHES[robot], lambda fault, n=tries: n, file, math.inf):
                print(f"{case.fault}: {case.seconds} {case.miss or case.stall or 'ok'}, took {case.took:.1f} s")
        missed = Counter(case.fault for case in file.cases if case.miss)
        wrong += [f"{case.fault}: {case.miss}" for case in file.cases if case.miss and missed[case.fault] > 1]
        wrong += [f"{fault.key}: never done" for fault in rows if not file.done(fault)]
    return wrong
