"""Until when a plan may be worked on."""

from collections.abc import Callable
from time import perf_counter

Deadline = Callable[[], bool]
"""Whether the time for a plan is over; asked again and again while it is worked on."""


def never() -> bool:
    """The deadline that does not come: equal inputs give equal plans."""
    return False


def after(started_at: float, budget: float) -> Deadline:
    """The deadline `budget` [s] after `started_at`, a time of perf_counter [s]."""
    return lambda: perf_counter() >= started_at + budget
