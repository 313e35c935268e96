"""Does faults again and again, repeats what the machine spoilt, and keeps every case as a line of a file."""

import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random
from typing import Any

from collplan_ros.bringup.ending import GraphError, Interrupted, StartError
from collplan_study.run.row_file import JsonLines

MOST_REPEATED = 20
"""Cases in a row that do not count after which a fault is left out: this machine is too busy for it."""


@dataclass(frozen=True)
class Measured:
    """What came of a fault once."""

    seconds: float | None = None
    """Time that the side took that must act, by its own clock [s]; None where there is nothing to time."""
    missed: str = ""  # why it counts as a miss whatever the time; empty where it does not
    stalled: str = ""  # why the machine was at fault, by the clock of the side that must act; the case is then repeated
    unbegun: str = ""  # why there was nothing to be seen of the fault, as of a robot that stood already; repeated too
    speed: float | None = None  # of the robot when the fault was done [m/s]; None where it is not measured
    distance: float | None = None  # way from then until it stood [m]; None where it is not measured

    def then(self, *wrong: str, **changes: Any) -> "Measured":
        """The same with changes, a miss for the first of these reasons that is not empty."""
        return replace(self, missed=next(filter(None, (self.missed, *wrong)), ""), **changes)


Act = Callable[[Any], Any]
"""Takes the bench; returns when the fault was done [s, steady clock], or whatever `measure` needs."""
Measure = Callable[[Any, Any], Measured]
"""Takes the bench and what `act` returned."""


@dataclass(frozen=True)
class Fault:
    """A row of the table.

    A bench drives the robot, `act` does the fault and says when, `measure` waits and says what came of it, and `undo`
    takes the fault away, whatever came of it.
    """

    name: str  # what is done, and what is measured where that is not the time until the robot is commanded to stand
    robot: str  # name of the bench
    limit: float | None  # longest time allowed [s]; None where nothing is timed
    act: Act
    measure: Measure
    undo: Callable[[Any], object] = lambda bench: None
    long: int = 100  # cases of `make faults-long`

    @property
    def key(self) -> str:
        """Name of the row: a fault may be done to more than one robot."""
        return f"{self.name}, {self.robot}"

    def why_late(self, seconds: float | None) -> str:
        """Why a time is a miss [s]; empty where it is none."""
        if self.limit is None or (seconds is not None and seconds <= self.limit):
            return ""
        return "never" if seconds is None else f"after {seconds:.3f} s, limit {self.limit:g} s"


class Bench:
    """What faults are done on. Here each case is a whole of its own; others drive a robot."""

    number = 0  # cases of the fault so far, those that do not count too: the seed of a case that is done by one
    chance = Random()  # random numbers of the case, the same in each run of it

    def __enter__(self) -> "Bench":
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def drive(self) -> None:
        """Makes the robot drive; here the case itself does."""


class BenchError(RuntimeError):
    """A bench on which no fault can be done: the robot does not drive."""


@dataclass(frozen=True)
class Case(Measured):
    """One line of the file: what came of a fault once, and what it took in all [s]; `missed` too where it was late."""

    fault: str = ""
    took: float = 0.0
    code: str = ""

    @property
    def counts(self) -> bool:
        """Whether it counts: the machine did not stall, and the fault could be seen."""
        return not self.stalled and not self.unbegun

    def __str__(self) -> str:
        word = f"MISSED {self.missed}" if self.missed else self.stalled or self.unbegun or "ok"
        figures = [f"{name} {value:.3f}" for name, value in vars(self).items() if isinstance(value, float)]
        return f"{self.fault}: {word}; {', '.join(figures)}"


class CaseFile:
    """Cases that are on disk as soon as they are done, so that a run that was broken off goes on where it was."""

    def __init__(self, path: Path, code: str = "") -> None:
        """Reads what is there of this state of the code; what another one did stays in the file and does not count."""
        self._file, self._code = JsonLines(path), code
        # those of the code as it is, in order
        self.cases = [Case(**record) for record in self._file.records() if record["code"] == code]

    def add(self, fault: Fault, measured: Measured, took: float) -> Case:
        """One more; what does not count is no miss."""
        case = Case(**vars(measured), fault=fault.key, took=took, code=self._code)
        case = replace(case, missed=case.missed or fault.why_late(case.seconds) if case.counts else "")
        self.cases.append(case)
        self._file.append(vars(case))
        return case

    def of(self, fault: Fault) -> list[Case]:
        """The cases of a fault, those that do not count too."""
        return [case for case in self.cases if case.fault == fault.key]

    def done(self, fault: Fault) -> int:
        """How many cases of a fault count."""
        return sum(case.counts for case in self.of(fault))


def measured_once(fault: Fault, bench: Any, number: int) -> Measured:
    """Does a fault once on a bench that is open, as case `number` of it."""
    bench.number, bench.chance = number, Random(f"{fault.key} {number}")
    bench.drive()
    try:
        return fault.measure(bench, fault.act(bench))
    finally:
        fault.undo(bench)


def run_bench(
    faults: Sequence[Fault], open_bench: Callable[[], Any], count: Callable[[Fault], int], file: CaseFile, end: float
) -> Iterator[Case]:
    """Does the faults of one bench in turns until each has its count, or until the time `end` [s, steady clock].

    A bench that fails is opened anew, once for each case; where it fails twice in a row, BenchError is raised. Any
    other failure is a miss of the case, and the bench is opened anew too.
    """
    repeated: Counter[str] = Counter()
    with ExitStack() as stack:
        bench, failed, begun = None, False, time.monotonic()
        while waiting := [f for f in faults if file.done(f) < count(f) and repeated[f.key] < MOST_REPEATED]:
            # the one that has the least: every row grows, however soon the time is over
            fault = min(waiting, key=file.done)
            if time.monotonic() >= end:
                return
            try:
                bench = bench or stack.enter_context(open_bench())
                measured = measured_once(fault, bench, len(file.of(fault)))
            except (BenchError, GraphError, StartError) as error:
                stack.close()
                if failed:
                    raise BenchError(str(error)) from error
                bench, failed = None, True
                print(f"{fault.name}: {error}; once more on a new graph", flush=True)
                continue
            except Interrupted:
                raise
            except Exception as error:
                stack.close()
                bench, measured = None, Measured(missed=f"{type(error).__name__}: {error}")
            failed, took = False, time.monotonic() - begun
            begun += took
            case = file.add(fault, measured, took)
            repeated[fault.key] = 0 if case.counts else repeated[fault.key] + 1
            yield case
