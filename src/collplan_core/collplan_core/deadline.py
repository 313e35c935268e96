"""Until when a plan may be worked on."""

from collections.abc import Callable
from time import perf_counter

Deadline = Callable[[], bool]
"""Whether the time for a plan is over; asked again and again while it is worked on."""


def never() -> bool:
    """The deadline that does not come: equal inputs give equal plans."""
    return False


def after(budget: float, clock: Callable[[], float] = perf_counter) -> Deadline:
    """The deadline `budget` [s] from now on, by `clock` [s]."""
    end = clock() + budget
    return lambda: clock() >= end


def after_looks(looks: int) -> Deadline:
    """The deadline that comes after so many looks at it: what a clock once decided, to be done again."""
    left = looks

    def is_over() -> bool:
        nonlocal left
        left -= 1
        return left < 0

    return is_over


class CountedDeadline:
    """A deadline, and how often it was looked at until it came.

    Attributes:
        looks: looks so far at which it had not come.
        came: whether it has come since; from then on it is over.
    """

    def __init__(self, deadline: Deadline) -> None:
        """Counts the looks at `deadline`."""
        self.looks = 0
        self.came = False
        self._deadline = deadline

    def __call__(self) -> bool:
        """Returns whether the time is over."""
        self.came = self.came or self._deadline()
        self.looks += not self.came
        return self.came
