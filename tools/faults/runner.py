"""Does faults, repeats what the machine spoilt, and keeps every case as a line of a file."""

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random
from typing import Any

from collplan_ros.bringup.failures import GraphError, Interrupted, StartError
from collplan_study.run.row_file import JsonLines
from faults.bench import BenchError
from faults.fault import Fault, Measured

MOST_REPEATED = 20
"""Cases in a row that do not count after which a fault is left out: this machine is too busy for it."""


@dataclass(frozen=True)
class Case:
    """One line of the file: what came of a fault once."""

    fault: str
    seconds: float | None
    miss: str
    stall: str
    speed: float | None
    distance: float | None
    took: float
    n: int = 1
    code: str = ""
    unbegun: str = ""

    @property
    def counts(self) -> bool:
        """Whether it counts: the machine did not stall, and the fault could be seen."""
        return not self.stall and not self.unbegun


class CaseFile:
    """Cases that are on disk as soon as they are done, so that a run that was broken off goes on where it was.

    Attributes:
        cases: those of the code as it is, in order.
    """

    def __init__(self, path: Path, code: str = "") -> None:
        """Reads what is there of this state of the code; what another one did stays in the file and does not count."""
        self._file, self._code = JsonLines(path), code
        self.cases = [case for record in self._file.records() if (case := Case(**record)).code == code]

    def add(self, case: Case) -> None:
        """One more."""
        case = replace(case, code=self._code)
        self.cases.append(case)
        self._file.append(vars(case))

    def done(self, fault: Fault) -> int:
        """How many cases of a fault count."""
        return sum(case.n for case in self.cases if case.counts and case.fault == fault.key)

    def number(self, fault: Fault) -> int:
        """How many cases of a fault there are, those that do not count too."""
        return sum(case.fault == fault.key for case in self.cases)


def measured_once(fault: Fault, bench: Any, number: int) -> Measured:
    """Does a fault once on a bench that is open, as case `number` of it."""
    bench.number, bench.chance = number, Random(f"{fault.key} {number}")
    bench.drive()
    try:
        return fault.measure(bench, fault.act(bench))
    finally:
        fault.undo(bench)


def judged(fault: Fault, measured: Measured, took: float) -> Case:
    """The case of what was measured; one that does not count is no miss."""
    miss = "" if measured.stalled or measured.unbegun else fault.why_missed(measured)
    way = measured.speed, measured.distance
    return Case(fault.key, measured.seconds, miss, measured.stalled, *way, took, measured.n, unbegun=measured.unbegun)


def run_bench(
    faults: Sequence[Fault], open_bench: Callable[[], Any], count: Callable[[Fault], int], file: CaseFile, end: float
) -> Iterator[Case]:
    """Does the faults of one bench in turns until each has its count, or until the time `end` [s, steady clock].

    A bench that fails is opened anew, once for each case. Any other failure is a miss of the case, and the bench is
    opened anew too.

    Raises:
        BenchError: it failed twice in a row.
    """
    repeated: Counter[str] = Counter()
    with ExitStack() as stack:
        bench = None
        failed = False
        begun = time.monotonic()
        while waiting := [f for f in faults if file.done(f) < count(f) and repeated[f.key] < MOST_REPEATED]:
            # the one that has the least: every row grows, however soon the time is over
            fault = min(waiting, key=file.done)
            if time.monotonic() >= end:
                return
            try:
                bench = bench or stack.enter_context(open_bench())
                measured = measured_once(fault, bench, file.number(fault))
            except (BenchError, GraphError, StartError) as error:
                stack.close()
                bench = None
                if failed:
                    raise BenchError(str(error)) from error
                failed = True
                print(f"{fault.name}: {error}; once more on a new graph", flush=True)
                continue
            except Interrupted:
                raise
            except Exception as error:
                stack.close()
                bench = None
                measured = Measured(missed=f"{type(error).__name__}: {error}")
            failed = False
            case = judged(fault, measured, time.monotonic() - begun)
            begun = time.monotonic()
            repeated[fault.key] = 0 if case.counts else repeated[fault.key] + 1
            file.add(case)
            yield case
