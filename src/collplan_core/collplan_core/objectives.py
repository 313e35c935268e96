"""The objectives by strategy name. An objective is a pure function; its memory is None at first."""

from collections.abc import Callable
from typing import Any

import numpy as np

from collplan_core.local_map.record import LocalMap
from collplan_core.params import Settings
from collplan_core.plan import Plan
from collplan_core.planner import NoPlan, plan_cycle
from collplan_core.rollout.objective import plan_rollout
from collplan_core.state import State
from collplan_core.strategies import STRATEGIES, TIME_TO_GOAL

__all__ = ["NoPlan", "Objective", "objective_for"]

Objective = Callable[[Any, LocalMap, State, np.ndarray, Settings], tuple[Plan, Any]]

OBJECTIVES: dict[str, Objective] = {
    **dict.fromkeys((*STRATEGIES, "custom"), plan_cycle),
    **dict.fromkeys(TIME_TO_GOAL, plan_rollout),
}


def objective_for(strategy: str) -> Objective:
    """(memory | None, local_map, state, goal, settings) -> (Plan, memory), for a strategy's name.

    The paper's plan from the state at the map's stamp; the time-to-goal ones from any later one.

    Raises:
        ValueError: unknown name.
    """
    if strategy not in OBJECTIVES:
        raise ValueError(f"strategy: got {strategy!r}, expected one of {', '.join(OBJECTIVES)}")
    return OBJECTIVES[strategy]
