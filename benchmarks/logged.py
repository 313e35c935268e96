"""States logged from closed-loop runs (simulated), each with the scan taken there and what the planner remembered."""

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from itertools import islice
from typing import Any

import numpy as np

from collplan_core.local_map import build_local_map
from collplan_core.parameters import Settings
from collplan_core.plan import NoPlan, Plan
from collplan_core.planners import local_mapping_of, map_period_of, planner_for
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import World, load_world
from collplan_core.worlds.raycast import simulate_scan
from omnipuck_sim.trial import run_trial


@cache
def settings_for(strategy: str) -> Settings:
    """The shipped settings with a strategy."""
    return Settings().with_values({"planner.strategy": strategy})


@dataclass(frozen=True, eq=False)
class Logged:
    """One cycle's inputs."""

    strategy: str
    world: World
    state: State
    scan: Scan
    memory: Any

    def plan(self) -> tuple[Plan, Any]:
        """A whole plan from the scan, as the planner makes it, and what the planner remembers then."""
        settings = settings_for(self.strategy)
        local_map = build_local_map(self.scan, self.state, settings.robot, local_mapping_of(settings))
        goal = np.asarray(self.world.goal)
        return planner_for(self.strategy).plan(self.memory, local_map, self.state, goal, settings)


def logged_states(strategies: Iterable[str], worlds: list[str], seeds: range, every: int = 1) -> list[Logged]:
    """Every so many of the states of each strategy's runs in each world with each seed, where it has a choice."""
    cases = [(strategy, load_world(spec), seed) for strategy in strategies for spec in worlds for seed in seeds]
    return [state for case in cases for state in islice(_states_of_run(*case), 0, None, every)]


def _states_of_run(strategy: str, world: World, seed: int) -> Iterator[Logged]:
    settings, memory = settings_for(strategy), None
    stride = round(map_period_of(settings.planner) * settings.simulator.mocap_rate)
    for t, x, y, vx, vy in run_trial(world, settings, seed).trajectory[::stride]:
        state = State(float(t), np.array([x, y]), np.array([vx, vy]), 0.0)
        logged = Logged(strategy, world, state, simulate_scan(world, state, settings.lidar), memory)
        with suppress(NoPlan):
            plan, memory = logged.plan()
            # with the goal in free space the paper's planner compares nothing: such cycles would lower the times
            if plan.n_before_pruning > 1:
                yield logged


def thinned(states: list[Logged], most: int) -> list[Logged]:
    """At most `most` of the states, evenly spread."""
    return states[:: max(1, -(-len(states) // most))]
