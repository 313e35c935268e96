"""Deadlines of planning."""

from collections.abc import Callable
from time import perf_counter

Deadline = Callable[[], bool]
"""Returns whether the time for a plan is over; called repeatedly during planning."""


def never() -> bool:
    """The deadline that does not come: equal inputs give equal plans."""
    return False


def after(budget: float, clock: Callable[[], float] = perf_counter) -> Deadline:
    """The deadline `budget` [s] from now on, by `clock` [s]."""
    end = clock() + budget
    return lambda: clock() >= end


def after_looks(looks: int) -> Deadline:
    """The deadline that passes after so many looks at it: repeats a deadline that a clock once set."""
    left = looks

    def is_over() -> bool:
        nonlocal left
        left -= 1
        return left < 0

    return is_over


class CountedDeadline:
    """A deadline, and how often it was looked at until it came."""

    def __init__(self, deadline: Deadline) -> None:
        """Counts the looks at `deadline`."""
        self.looks = 0  # number of looks so far at which it had not passed
        self.came = False  # whether it has passed
        self._deadline = deadline

    def __call__(self) -> bool:
        """Returns whether the time is over."""
        self.came = self.came or self._deadline()
        self.looks += not self.came
        return self.came
