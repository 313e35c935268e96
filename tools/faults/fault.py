"""A fault that is done to a robot again and again, and what came of it once."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Act = Callable[[Any], Any]
"""Takes the bench; returns when the fault was done [s, steady clock], or whatever `measure` needs."""
NOTHING: Callable[[Any], None] = lambda bench: None  # noqa: E731


@dataclass(frozen=True)
class Measured:
    """What came of a fault once.

    Attributes:
        seconds: time that the side took that must act, by its own clock [s]; None where there is nothing to time.
        missed: why it counts as a miss whatever the time; empty where it does not.
        stalled: why the machine was at fault, by the clock of the side that must act; the case is then repeated.
        unbegun: why there was nothing to be seen of the fault, as of a robot that stood already; repeated too.
        speed: of the robot when the fault was done [m/s]; None where it is not measured.
        distance: way from then until it stood [m]; None where it is not measured.
        n: cases that this one stands for, where there are many that take no time.
    """

    seconds: float | None = None
    missed: str = ""
    stalled: str = ""
    unbegun: str = ""
    speed: float | None = None
    distance: float | None = None
    n: int = 1


@dataclass(frozen=True)
class Fault:
    """A row of the table.

    A bench drives the robot, `act` does the fault and says when, `measure` waits and says what came of it, and `undo`
    takes the fault away, whatever came of it.

    Attributes:
        name: what is done, and what is measured where that is not the time until the robot is commanded to stand.
        robot: name of the bench.
        limit: longest time allowed [s]; None where nothing is timed.
        act: does it.
        measure: takes the bench and what `act` returned.
        undo: takes the bench.
        long: cases of `make faults-long`.
        short: cases of `make faults` at most; 0 where only the long run does it.
    """

    name: str
    robot: str
    limit: float | None
    act: Act
    measure: Callable[[Any, Any], Measured]
    undo: Callable[[Any], None] = NOTHING
    long: int = 100
    short: int = 1_000_000

    @property
    def key(self) -> str:
        """Name of the row: a fault may be done to more than one robot."""
        return f"{self.name}, {self.robot}"

    def why_missed(self, measured: Measured) -> str:
        """Why a case is a miss; empty where it is none."""
        if measured.missed:
            return measured.missed
        if self.limit is None or (measured.seconds is not None and measured.seconds <= self.limit):
            return ""
        return "never" if measured.seconds is None else f"after {measured.seconds:.3f} s, limit {self.limit:g} s"
