"""Where a cycle's time goes: a clock around each stage of the planner, in a pass of its own."""

from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter_ns
from typing import Any
from unittest.mock import patch

import logged as logged_module
from logged import Logged, cycle, settings_for

from collplan_core import planner

STAGES = {
    "local_map": [(logged_module, "build_local_map")],
    "space_and_pruning": [(planner, "_space")],
    "costs": [(planner, name) for name in ("position_costs", "_position_risks", "evaluate", "choose")],
    "trajectory": [(planner, "_trajectory")],
    "foreseen_contacts": [(planner, "foreseen_contacts")],
}


def stage_shares(states: list[Logged], pruned: bool = True) -> dict[str, float]:
    """Share of the cycles' time by stage; "rest" is what lies between the stages."""
    spent: dict[str, int] = defaultdict(int)
    cases = [(state, settings_for(state.strategy, pruned)) for state in states]
    begun = perf_counter_ns()
    with _clocks(spent):
        for state, settings in cases:
            cycle(state, settings)
    whole = perf_counter_ns() - begun
    shares = {stage: spent[stage] / whole for stage in STAGES}
    return {name: round(share, 3) for name, share in {**shares, "rest": 1.0 - sum(shares.values())}.items()}


@contextmanager
def _clocks(spent: dict[str, int]) -> Iterator[None]:
    patches = [
        patch.object(module, name, _clocked(getattr(module, name), stage, spent))
        for stage, functions in STAGES.items()
        for module, name in functions
    ]
    for each in patches:
        each.start()
    try:
        yield
    finally:
        for each in patches:
            each.stop()


def _clocked(function: Callable[..., Any], stage: str, spent: dict[str, int]) -> Callable[..., Any]:
    def call(*args: Any, **kwargs: Any) -> Any:
        begun = perf_counter_ns()
        result = function(*args, **kwargs)
        spent[stage] += perf_counter_ns() - begun
        return result

    return call
