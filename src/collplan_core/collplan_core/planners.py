"""The planners by strategy name: all that nodes and trials need of a strategy."""

import inspect
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from collplan_core.deadline import Deadline, after, never
from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.paper_planner.plan_cycle import plan_cycle as plan_spline
from collplan_core.paper_planner.trajectory import MAP_PERIOD as SPLINE_MAP_PERIOD
from collplan_core.parameters import LocalMapping, ParameterError, Planning, Settings
from collplan_core.plan import Plan
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.strategies import NAMES, PAPER_WEIGHTS, TIME_TO_GOAL
from collplan_core.time_to_goal_planner.boundary_memory.working import RememberedBoundaries
from collplan_core.time_to_goal_planner.known_map import given_map
from collplan_core.time_to_goal_planner.model import MAP_PERIOD as ROLLOUT_MAP_PERIOD
from collplan_core.time_to_goal_planner.plan_cycle import RolloutMemory
from collplan_core.time_to_goal_planner.plan_cycle import plan_cycle as plan_rollout
from collplan_core.validation import check_type, finite
from collplan_core.worlds import World

BUDGET_SHARE = 0.5
"""Time budget of refinement where time_to_goal.time_budget is 0, as a share of map_period: plans must not be late."""

ROUNDING = 1e-6
"""Largest difference of a plan's first time, which may be a sum, from its stamp [s]."""


class PlanFunction(Protocol):
    """Signature of a planner's plan function."""

    def __call__(
        self,
        memory: Any,
        local_map: LocalMap,
        state: State,
        goal: np.ndarray,
        settings: Settings,
        deadline: Deadline = never,
    ) -> tuple[Plan, Any]:
        """Returns the plan from `state` to `goal` (2,) [m] and the next cycle's memory; `memory` is None at first.

        Raises:
            NoPlan: there is nothing to aim at.
        """


@dataclass(frozen=True)
class Planner:
    """One way to plan.

    Raises:
        TypeError, ValueError: at construction, `plan` does not take six arguments, or map_period is not above 0.
    """

    plan: PlanFunction  # one cycle, from a local map to a plan
    map_period: float  # T_map where planner.map_period is 0 [s]
    starts_at_newest_pose: bool = True
    """Whether a plan starts at the newest pose; otherwise at the pose of the map's scan."""
    replans_after_impact: bool = False  # whether an impact requires a plan at once
    gives_up_closed_off_goal: bool = False  # whether NoPlan means that seen boundaries close off the goal
    boundaries: Callable[[Any], RememberedBoundaries | None] = lambda memory: None
    """From a memory, the remembered boundaries for display; None where it remembers none."""
    half_side: Callable[[Settings], float] = lambda settings: settings.local_map.half_side
    """Half the side of the local map that it plans in [m]."""
    without_plan: Callable[[Any], Any] = lambda memory: None
    """From a memory, one without the plan in force, for a robot that was led aside."""
    known_map: Callable[[World, Settings], Any] | None = None
    """From world and settings, a first memory that holds the whole world; None where it can hold none."""

    def __post_init__(self) -> None:
        wanted = "memory, local_map, state, goal, settings, deadline"
        try:
            inspect.signature(self.plan).bind(*wanted.split(", "))
        except TypeError as error:
            raise TypeError(f"plan: got {self.plan!r:.80} ({error}), expected a function of {wanted}") from None
        if not (isinstance(self.map_period, float | int) and 0.0 < self.map_period < np.inf):
            raise ValueError(f"map_period: got {self.map_period!r:.80}, expected a time above 0 [s]")


PAPER = Planner(
    plan_spline,
    SPLINE_MAP_PERIOD,
    starts_at_newest_pose=False,
)
ROLLOUTS = Planner(
    plan_rollout,
    ROLLOUT_MAP_PERIOD,
    starts_at_newest_pose=True,
    replans_after_impact=True,
    gives_up_closed_off_goal=True,
    boundaries=lambda memory: memory.remembered,
    half_side=lambda settings: settings.time_to_goal.half_side,
    without_plan=RolloutMemory.without_plan,
    known_map=given_map,
)

PLANNERS: dict[str, Planner] = {
    **dict.fromkeys((*PAPER_WEIGHTS, "custom"), PAPER),
    **dict.fromkeys(TIME_TO_GOAL, ROLLOUTS),
}


def register(strategy: str, planner: Planner) -> None:
    """Makes a planner what `planner.strategy` chooses by this name, a new one or one that there is.

    Raises:
        TypeError: the strategy is no str, or the planner no Planner; in each cycle, it returns no plan and memory.
    """
    check_type("strategy", strategy, str)
    check_type("planner", planner, Planner, ", as in Planner(plan, map_period=0.1)")
    PLANNERS[strategy] = replace(planner, plan=_checked(strategy, planner.plan))
    if strategy not in NAMES:
        NAMES.append(strategy)


def _checked(strategy: str, plan: PlanFunction) -> PlanFunction:
    def cycle(*given: Any, **named: Any) -> tuple[Plan, Any]:
        found = plan(*given, **named)
        if not (isinstance(found, tuple) and len(found) == 2 and isinstance(found[0], Plan)):
            raise TypeError(f"planner {strategy}: returned {found!r:.80}, expected a Plan and the next memory")
        if not abs((begins := found[0].times[0]) - found[0].stamp) <= ROUNDING:
            raise ValueError(f"planner {strategy}: times[0]: got {begins}, expected its stamp, {found[0].stamp}")
        return found

    return cycle


def planner_for(strategy: str) -> Planner:
    """The planner of a strategy.

    Raises:
        ValueError: unknown name.
    """
    if strategy not in PLANNERS:
        raise ValueError(f"strategy: got {strategy!r}, expected one of {', '.join(PLANNERS)}")
    return PLANNERS[strategy]


def plan_once(scan: Scan, state: State, goal: np.ndarray, settings: Settings, memory: Any = None) -> tuple[Plan, Any]:
    """The plan by the chosen strategy from a scan taken at `state` to a goal (2,) [m], and the next call's memory.

    Raises:
        NoPlan: there is nothing to aim at.
        ScanError: the scan cannot be used.
        TypeError, ValueError: an argument is of another type, or the goal not two finite numbers.
    """
    check_type("scan", scan, Scan)
    check_type("state", state, State, ", as in State.at_rest(world.start)")
    check_type("settings", settings, Settings, ", as in Settings()")
    goal = finite("goal", goal, (2,), "expected x, y [m]")
    local_map = build_local_map(scan, state, settings.robot, local_mapping_of(settings))
    return planner_for(settings.planner.strategy).plan(memory, local_map, state, goal, settings)


def map_period_of(planner: Planning) -> float:
    """T_map [s]: the parameter, or where that is 0 the planner's own."""
    return planner.map_period or planner_for(planner.strategy).map_period


def deadlines(clock: Callable[[], float]) -> Callable[[Settings], Deadline]:
    """Gives until when a plan that is begun now may be worked on, by `clock` [s]."""

    def deadline(settings: Settings) -> Deadline:
        return after(settings.time_to_goal.time_budget or BUDGET_SHARE * map_period_of(settings.planner), clock)

    return deadline


def local_mapping_of(settings: Settings) -> LocalMapping:
    """Local-map parameters for the planner of the chosen strategy."""
    return _with_half_side(settings.local_map, planner_for(settings.planner.strategy).half_side(settings))


@lru_cache(maxsize=8)
def _with_half_side(mapping: LocalMapping, half_side: float) -> LocalMapping:
    """Kept, as it is asked for at each scan and plan, and checks all values anew."""
    return replace(mapping, half_side=half_side)


def first_memory(settings: Settings, world: World | None) -> Any:
    """A planner's first memory: None, or all of `world` (None for a node) where `trial.known_map` asks for it.

    Raises:
        ParameterError: `trial.known_map` is true for a node, or for a planner that cannot hold a map.
    """
    if not settings.trial.known_map:
        return None
    if world is None:
        raise ParameterError("trial.known_map: got True, expected False: planner_node is never given a map")
    known_map = planner_for(settings.planner.strategy).known_map
    if known_map is None:
        able = ", ".join(name for name, planner in PLANNERS.items() if planner.known_map)
        strategy = settings.planner.strategy
        raise ParameterError(f"trial.known_map: got True with planner.strategy {strategy}, expected one of {able}")
    return known_map(world, settings)
