"""The planner's cycles along a simulated run, made again one by one: what it saw, and what it made of it."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.planners import local_mapping_of, map_period_of, planner_for
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan
from omnipuck_sim.trial import run_trial


class Cycle(NamedTuple):
    """One planning cycle: its inputs, the memory it began with and the one it left, and its plan."""

    world: World
    settings: Settings
    state: State
    scan: Scan
    local_map: LocalMap
    before: Any
    memory: Any
    plan: Plan


def cycle_at(world: World, settings: Settings, state: State, memory: Any = None) -> Cycle:
    """The cycle of a robot in this state at the moment of its scan."""
    scan = simulate_scan(world, state, settings.lidar)
    local_map = build_local_map(scan, state, settings.robot, local_mapping_of(settings))
    plan, after = planner_for(settings.planner.strategy).plan(memory, local_map, state, world.goal, settings)
    return Cycle(world, settings, state, scan, local_map, memory, after, plan)


def cycles_of_run(world: World, settings: Settings, seed: int = 0) -> Iterator[Cycle]:
    """The cycles along the true path of one trial, each with the memory of those before."""
    trajectory = run_trial(world, settings, seed).trajectory
    memory = None
    for t, x, y, vx, vy in trajectory[:: round(map_period_of(settings) * settings.simulator.mocap_rate)]:
        state = State(float(t), np.array([x, y]), np.array([vx, vy]), 0.0)
        cycle = cycle_at(world, settings, state, memory)
        memory = cycle.memory
        yield cycle
