"""Times of calls in rounds that take turns, and ratios of such rounds."""

import statistics
from collections.abc import Callable, Iterable, Mapping
from time import perf_counter_ns
from typing import Any, TypeVar

import numpy as np

Case = TypeVar("Case")
Rounds = list[list[float]]
"""Times of repeated calls, round by round [us]."""


def time_each(call: Callable[[Case], Any], cases: Iterable[Case]) -> list[float]:
    """Wall time of one call for each case [us]."""
    times = []
    for case in cases:
        started_at = perf_counter_ns()
        call(case)
        times.append((perf_counter_ns() - started_at) / 1e3)
    return times


def in_turn(measures: Mapping[str, Callable[[int], list[float]]], rounds: int) -> dict[str, Rounds]:
    """The rounds of each measure, which gets the number of its round; one of each, then the next of each."""
    timed: dict[str, Rounds] = {name: [] for name in measures}
    for number in range(rounds):
        for name, measure in measures.items():
            timed[name].append(measure(number))
    return timed


def summary(rounds: Rounds) -> dict[str, float | int]:
    """median_us, p99_us, n."""
    every = np.concatenate(rounds)
    median, p99 = np.percentile(every, [50, 99])
    return {"median_us": round(float(median), 2), "p99_us": round(float(p99), 2), "n": len(every)}


def compared(ours: Rounds, peer: Rounds) -> dict[str, Any]:
    """Both summaries; median, lowest and highest over the rounds of the ratio of a round's medians."""
    ratios = [statistics.median(a) / statistics.median(b) for a, b in zip(ours, peer, strict=True)]
    ratio = {"ratio": statistics.median(ratios), "lowest": min(ratios), "highest": max(ratios)}
    return {**ratio, "ours": summary(ours), "peer": summary(peer)}
