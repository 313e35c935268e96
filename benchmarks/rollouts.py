"""The time-to-goal planner: how long a whole plan takes, stage by stage, and its coarse rollouts alone."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from inspect import signature
from typing import Any
from unittest.mock import patch

import numpy as np
from stages import Stages, shares
from timing import Timed, time_each

from collplan_core.deadline import Deadline, never
from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.loop import planner_loop, sensed_scans
from collplan_core.loop.sensed_scans import PlacedScan
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.planners import local_mapping_of, planner_for
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.time_to_goal_planner import initial_plans
from collplan_core.time_to_goal_planner import plan_cycle as cycle
from collplan_core.time_to_goal_planner.initial_plans import SWITCH_STEPS, CoarsePlans
from collplan_core.worlds import load_world
from omnipuck_sim.trial import run_trial

SETTINGS = Settings().with_values({"planner.strategy": "bounce"})
FAMILIES = ("l", "u", "z", "baffles", "random", "serpentine")
SEED = 100
"""Seed of each family's world; the study of bounces holds out others."""
EVERY = 4
"""One call of so many is kept: each holds its own map."""
STAGES: Stages = {
    "local_map": [(sys.modules[__name__], "build_local_map")],
    "remember": [(cycle, "remember")],
    "shortest_paths": [(cycle, "shortest_paths")],
    "coarse": [(cycle, "coarse_plans")],
    "extension": [(cycle, "tracked"), (cycle, "roll"), (initial_plans, "roll"), (initial_plans, "extend_to_goal")],
    "refinement": [(cycle, "refine")],
    "smoothing": [(cycle, "smoothed")],
}


@dataclass(frozen=True, eq=False)
class Call:
    """What the planner got in a run: a scan, the state at it, its own memory, the newest state and the goal."""

    scan: Scan
    at_scan: State
    memory: Any
    state: State
    goal: np.ndarray


@dataclass(frozen=True, eq=False)
class Work:
    """What one plan takes: arguments and results of all coarse rollouts, how many it made, and changes tried."""

    arguments: tuple[Any, ...]
    coarse: CoarsePlans
    made: int
    proposals: int


def logged_calls(families: Sequence[str]) -> list[Call]:
    """Calls of the planner in a run (simulated) of one world of each family, with the run's own noise."""
    calls: list[Call] = []
    with _listening(calls):
        for family in families:
            run_trial(load_world(f"{family}:{SEED}"), SETTINGS, seed=0)
    return calls


@contextmanager
def _listening(calls: list[Call]) -> Iterator[None]:
    scanned: dict[float, tuple[Scan, State]] = {}
    made = 0

    def placed(scan: Scan, state: State, local_map: LocalMap) -> PlacedScan:
        scanned[local_map.stamp] = scan, state
        return PlacedScan(scan, state, local_map)

    def plan_of(
        memory: Any,
        local_map: LocalMap,
        state: State,
        goal: np.ndarray,
        settings: Settings,
        deadline: Deadline = never,
    ) -> Any:
        nonlocal made
        result = cycle.plan_cycle(memory, local_map, state, goal, settings)
        if made % EVERY == 0:
            calls.append(Call(*scanned[local_map.stamp], memory, state, goal))
        made += 1
        return result

    planner = replace(planner_for("bounce"), plan=plan_of)
    with (
        patch.object(sensed_scans, "PlacedScan", placed),
        patch.object(planner_loop, "planner_for", lambda _: planner),
    ):
        yield


def rollouts(calls: list[Call], rounds: int) -> dict[str, Any]:
    """Times, stages and counts; whole plans and rollouts alone in rounds that take turns."""
    works = [_work(call) for call in calls]
    plans, coarse = Timed(), Timed()
    for _ in range(rounds):
        plans.rounds.append(time_each(_plan, calls))
        coarse.rounds.append(time_each(lambda work: cycle.coarse_plans(*work.arguments), works))
    return {
        "plan_to_goal": plans.summary(),
        "steps_per_second": _steps_per_second(works),
        "coarse": coarse.summary(),
        "stages": shares(STAGES, _plan, calls),
        "counts": _counts(works),
    }


def _plan(call: Call) -> Plan:
    """A whole plan from a scan."""
    local_map = build_local_map(call.scan, call.at_scan, SETTINGS.robot, local_mapping_of(SETTINGS))
    plan, _ = cycle.plan_cycle(call.memory, local_map, call.state, call.goal, SETTINGS)
    return plan


def _work(call: Call) -> Work:
    coarse, refine = cycle.coarse_plans, cycle.refine
    rolled: list[tuple[Any, ...]] = []
    tried: list[int] = []

    def coarse_plans(*arguments: Any) -> Any:
        result = coarse(*arguments)
        # all to their ends: only then is the number of steps known
        whole = (*arguments[:4], np.inf, np.inf)
        rolled.append((whole, coarse(*whole), int(np.isfinite(result.costs).sum())))
        return result

    def refine_counted(*arguments: Any) -> Any:
        tried.append(signature(refine).bind(*arguments).arguments["count"])
        return refine(*arguments)

    with patch.object(cycle, "coarse_plans", coarse_plans), patch.object(cycle, "refine", refine_counted):
        _plan(call)
    ((arguments, coarse_result, made),) = rolled
    return Work(arguments, coarse_result, made, sum(tried))


def _counts(works: list[Work]) -> dict[str, float]:
    """Per plan, in the median: rollouts that differ, those not given up, and changes tried on whole plans."""
    rolled = [np.isfinite(work.coarse.costs).sum() for work in works]
    return {
        "rollouts": float(np.median(rolled)),
        "rollouts_not_given_up": float(np.median([work.made for work in works])),
        "proposals": float(np.median([work.proposals for work in works])),
    }


def _steps_per_second(works: list[Work]) -> int:
    """Steps of the dynamics a second, where no rollout is given up or arrives: only then is their number known."""
    far = [work for work in works if not _arrives(work)]
    taken = sum(time_each(lambda work: cycle.coarse_plans(*work.arguments), far)) / 1e6
    return round(sum(_steps(work) for work in far) / taken)


def _arrives(work: Work) -> bool:
    goal, made = work.arguments[0].constants.goal, np.isfinite(work.coarse.costs)
    x, y = work.coarse.ends[made][:, :2].T
    return bool((np.hypot(x - goal.x, y - goal.y) <= goal.tolerance).any())


def _steps(work: Work) -> int:
    """Steps of whole coarse plans: each first velocity to its last switch, and each second one from each switch on."""
    n, n_steps = len(work.arguments[2]), work.arguments[3]
    switches = np.minimum(SWITCH_STEPS, n_steps)
    second = np.full(len(switches), n - 1)
    second[-1] = n
    return int(n * (switches[-1] + (second * (n_steps - switches)).sum()))
