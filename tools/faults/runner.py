"""Does faults, repeats what the machine spoilt, and keeps every case as a line of a file."""

import json
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from collplan_ros.bringup.failures import GraphError, StartError
from faults.fault import Fault, Measured

MOST_STALLS = 20
"""Stalls in a row after which a fault is left out: this machine is too busy for it."""


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

    @property
    def counts(self) -> bool:
        """Whether it counts: the machine did not stall."""
        return not self.stall


class CaseFile:
    """Cases that are on disk as soon as they are done, so that a run that was broken off goes on where it was.

    Attributes:
        cases: those of the code as it is, in order.
    """

    def __init__(self, path: Path, code: str = "") -> None:
        """Reads what is there of this state of the code; what another one did stays in the file and does not count."""
        self._path = path
        self._code = code
        path.parent.mkdir(parents=True, exist_ok=True)
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        found = [Case(**json.loads(line)) for line in lines]
        self.cases = [case for case in found if case.code == code]

    def add(self, case: Case) -> None:
        """One more."""
        case = replace(case, code=self._code)
        self.cases.append(case)
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(vars(case)) + "\n")

    def done(self, fault: Fault) -> int:
        """How many cases of a fault count."""
        return sum(case.n for case in self.cases if case.counts and case.fault == fault.key)


def case_of(fault: Fault, bench: Any) -> Case:
    """Does a fault once on a bench that is open."""
    begun = time.monotonic()
    bench.drive()
    try:
        measured = fault.measure(bench, fault.act(bench))
    finally:
        fault.undo(bench)
    return judged(fault, measured, time.monotonic() - begun)


def judged(fault: Fault, measured: Measured, took: float) -> Case:
    """The case of what was measured; one in which the machine stalled is no miss."""
    miss = "" if measured.stalled else fault.why_missed(measured)
    way = measured.speed, measured.distance
    return Case(fault.key, measured.seconds, miss, measured.stalled, *way, took, measured.n)


def run_bench(
    faults: Sequence[Fault], open_bench: Callable[[], Any], count: Callable[[Fault], int], file: CaseFile, end: float
) -> Iterator[Case]:
    """Does the faults of one bench in turns until each has its count, or until the time `end` [s, steady clock].

    A bench that fails is opened anew, once for each case.

    Raises:
        BenchError: it failed twice in a row.
    """
    stalls: Counter[str] = Counter()
    with ExitStack() as stack:
        bench = None
        failed = False
        while waiting := [f for f in faults if file.done(f) < count(f) and stalls[f.key] < MOST_STALLS]:
            # the one that has the least: every row grows, however soon the time is over
            fault = min(waiting, key=file.done)
            if time.monotonic() >= end:
                return
            try:
                bench = bench or stack.enter_context(open_bench())
                case = case_of(fault, bench)
            except (BenchError, GraphError, StartError) as error:
                stack.close()
                bench = None
                if failed:
                    raise BenchError(str(error)) from error
                failed = True
                print(f"{fault.name}: {error}; once more on a new graph", flush=True)
                continue
            failed = False
            stalls[fault.key] = 0 if case.counts else stalls[fault.key] + 1
            file.add(case)
            yield case


class BenchError(RuntimeError):
    """A bench on which no fault can be done: the robot does not drive."""
