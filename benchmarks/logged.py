"""States logged from closed-loop runs (simulated), each with the scan taken there and what the planner remembered."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from collplan_core.local_map import build_local_map
from collplan_core.parameters import Settings
from collplan_core.plan import NoPlan, Plan
from collplan_core.planners import local_mapping_of, map_period_of, planner_for
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.strategies import PAPER_WEIGHTS
from collplan_core.worlds import World, load_world
from collplan_core.worlds.raycast import simulate_scan
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialResult


@dataclass(frozen=True, eq=False)
class Logged:
    """One cycle's inputs, and the plan that the shipped settings make of them."""

    strategy: str
    world: World
    state: State
    scan: Scan
    goal: np.ndarray
    memory: Any
    plan: Plan

    @property
    def chooses(self) -> bool:
        """Whether candidates are compared: the goal is not in free space yet."""
        return self.plan.n_before_pruning > 1


def settings_for(strategy: str, pruned: bool = True) -> Settings:
    """The shipped settings with a strategy, with or without both prunings."""
    shipped = Settings()
    planner = replace(shipped.planner, strategy=strategy, position_pruning=pruned, velocity_pruning=pruned)
    return replace(shipped, planner=planner)


def cycle(logged: Logged, settings: Settings) -> Plan:
    """A whole plan from a scan: local map, candidates, costs, trajectory."""
    local_map = build_local_map(logged.scan, logged.state, settings.robot, local_mapping_of(settings))
    plan, _ = planner_for(settings.planner.strategy).plan(logged.memory, local_map, logged.state, logged.goal, settings)
    return plan


def logged_states(worlds: list[str], seeds: range) -> list[Logged]:
    """The states of every run of each strategy in each world with each seed."""
    cases = [(strategy, load_world(spec), seed) for strategy in PAPER_WEIGHTS for spec in worlds for seed in seeds]
    return [state for case in cases for state in _states_of_run(*case)]


def _states_of_run(strategy: str, world: World, seed: int) -> Iterator[Logged]:
    settings = settings_for(strategy)
    run = run_trial(world, settings, seed)
    goal, memory = np.asarray(world.goal), None
    for state in _states_every(run, settings):
        scan = simulate_scan(world, state, settings.lidar)
        local_map = build_local_map(scan, state, settings.robot, local_mapping_of(settings))
        try:
            plan, after = planner_for(strategy).plan(memory, local_map, state, goal, settings)
        except NoPlan:
            continue
        yield Logged(strategy, world, state, scan, goal, memory, plan)
        memory = after


def _states_every(run: TrialResult, settings: Settings) -> Iterator[State]:
    """The true states of a run, one each map_period."""
    for t, x, y, vx, vy in run.trajectory[:: round(map_period_of(settings.planner) * settings.simulator.mocap_rate)]:
        yield State(float(t), np.array([x, y]), np.array([vx, vy]), 0.0)
