"""Where a cycle's time goes: a clock around each stage of a planner, in a pass of its own."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from time import perf_counter_ns
from types import ModuleType
from typing import Any
from unittest.mock import patch

import logged as logged_module
from logged import Logged, cycle, settings_for
from timing import Case

from collplan_core.paper_planner import plan_cycle as planner

Stages = Mapping[str, Sequence[tuple[ModuleType, str]]]
"""The functions that make up each stage: the module that calls each, and its name there."""

PAPER_STAGES: Stages = {
    "local_map": [(logged_module, "build_local_map")],
    "space_and_pruning": [(planner, "sampling_space")],
    "costs": [(planner, "_evaluated"), (planner, "_least")],
    "trajectory": [(planner, "make_trajectory")],
    "foreseen_contacts": [(planner, "foreseen_contacts")],
}


def stage_shares(states: list[Logged], pruned: bool = True) -> dict[str, float]:
    """Share of the time of the paper's cycles by stage."""
    return shares(PAPER_STAGES, lambda state: cycle(state, settings_for(state.strategy, pruned)), states)


def shares(stages: Stages, call: Callable[[Case], Any], cases: Iterable[Case]) -> dict[str, float]:
    """Share by stage of the time of one call for each case; "rest" is what lies between the stages."""
    spent: dict[str, int] = defaultdict(int)
    begun = perf_counter_ns()
    with _clocks(stages, spent):
        for case in cases:
            call(case)
    whole = perf_counter_ns() - begun
    by_stage = {stage: spent[stage] / whole for stage in stages}
    return {name: round(share, 3) for name, share in {**by_stage, "rest": 1.0 - sum(by_stage.values())}.items()}


@contextmanager
def _clocks(stages: Stages, spent: dict[str, int]) -> Iterator[None]:
    patches = [
        patch.object(module, name, _clocked(getattr(module, name), stage, spent))
        for stage, functions in stages.items()
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
