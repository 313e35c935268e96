"""The planners by strategy name: how each plans, and how its plans are followed."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from collplan_core.command import Command
from collplan_core.control.memory import ControllerMemory
from collplan_core.local_map.record import LocalMap
from collplan_core.paper_planner.follow import follow as follow_spline
from collplan_core.paper_planner.plan_cycle import plan_cycle as plan_spline
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.state import State
from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL
from collplan_core.time_to_goal_planner.follow import follow as follow_rollout
from collplan_core.time_to_goal_planner.plan_cycle import plan_cycle as plan_rollout

PlanFunction = Callable[[Any, LocalMap, State, np.ndarray, Settings], tuple[Plan, Any]]
FollowFunction = Callable[[ControllerMemory, Plan, Any, State, float, Settings], tuple[Command, ControllerMemory]]


class Planner(NamedTuple):
    """One way to plan.

    Attributes:
        plan: (memory | None, local_map, state, goal, settings) -> (Plan, memory). The paper's plans from the state at
            the map's stamp, the time-to-goal one from any later one. Raises NoPlan.
        follow: (memory, plan, the plan's local map, state, now, settings) -> (Command, memory), one control period.
            The time-to-goal one needs no map.
    """

    plan: PlanFunction
    follow: FollowFunction


PAPER = Planner(plan_spline, follow_spline)
TIME_TO_GOAL_PLANNER = Planner(plan_rollout, follow_rollout)

PLANNERS: dict[str, Planner] = {
    **dict.fromkeys((*PAPER_WEIGHTS, "custom"), PAPER),
    **dict.fromkeys(TIME_TO_GOAL, TIME_TO_GOAL_PLANNER),
}


def planner_for(strategy: str) -> Planner:
    """The planner of a strategy.

    Raises:
        ValueError: unknown name.
    """
    if strategy not in PLANNERS:
        raise ValueError(f"strategy: got {strategy!r}, expected one of {', '.join(PLANNERS)}")
    return PLANNERS[strategy]
