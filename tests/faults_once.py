"""Every fault of some robots once, on graphs that are shared."""

import math
from collections.abc import Iterable
from pathlib import Path

from faults.rows import BENCHES, FAULTS
from faults.runner import CaseFile, run_bench


def wrong_of(robots: Iterable[str], folder: Path) -> list[str]:
    """What has not come out as it must, of each row of `make faults`."""
    wrong = []
    for robot in robots:
        rows = [fault for fault in FAULTS if fault.robot == robot and fault.short]
        file = CaseFile(folder / f"{robot}.jsonl")
        for case in run_bench(rows, BENCHES[robot], lambda fault: 1, file, math.inf):
            result = case.miss or case.stall or case.unbegun or "ok"
            print(f"{case.fault}: {case.seconds} {result}, took {case.took:.1f} s", flush=True)
        wrong += [f"{case.fault}: {case.miss}" for case in file.cases if case.miss]
        wrong += [f"{fault.key}: never done" for fault in rows if not file.done(fault)]
    return wrong
