"""What faults are done on."""

from random import Random


class Bench:
    """A bench on which each case is a whole of its own; others drive a robot.

    Attributes:
        number: cases of the fault so far, those that do not count too: the seed of a case that is done by one.
        chance: random numbers of the case, the same in each run of it.
    """

    number = 0
    chance = Random()

    def __enter__(self) -> "Bench":
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def drive(self) -> None:
        """Makes the robot drive; here the case itself does."""


class BenchError(RuntimeError):
    """A bench on which no fault can be done: the robot does not drive."""
