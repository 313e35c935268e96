"""Times of calls, and ratios of interleaved rounds."""

import statistics
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from time import perf_counter_ns
from typing import Any, TypeVar

import numpy as np

Case = TypeVar("Case")


@dataclass
class Timed:
    """Times of repeated calls, round by round [us]."""

    rounds: list[list[float]] = field(default_factory=list)

    @property
    def medians(self) -> list[float]:
        """Median of each round [us]."""
        return [statistics.median(times) for times in self.rounds]

    @property
    def all(self) -> np.ndarray:
        """(n,) every time of every round [us]."""
        return np.concatenate([np.zeros(0), *self.rounds])

    def summary(self) -> dict[str, float | int]:
        """median_us, p99_us, n."""
        median, p99 = np.percentile(self.all, [50, 99])
        return {"median_us": round(float(median), 2), "p99_us": round(float(p99), 2), "n": len(self.all)}


def time_each(call: Callable[[Case], Any], cases: Iterable[Case]) -> list[float]:
    """Wall time of one call for each case [us]."""
    times = []
    for case in cases:
        started_at = perf_counter_ns()
        call(case)
        times.append((perf_counter_ns() - started_at) / 1e3)
    return times


def ratio(ours: Timed, theirs: Timed) -> dict[str, float]:
    """Ratio of ours to theirs: median, lowest and highest over the rounds of the ratio of a round's medians."""
    return ratio_of(ours.medians, theirs.medians)


def ratio_of(ours: Sequence[float], theirs: Sequence[float]) -> dict[str, float]:
    """Ratio of ours to theirs from one figure of each round: median, lowest and highest of the rounds' ratios."""
    each = [a / b for a, b in zip(ours, theirs, strict=True)]
    return {"ratio": statistics.median(each), "lowest": min(each), "highest": max(each)}
