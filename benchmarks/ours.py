"""This project's side of each comparison, one round at a time."""

from dataclasses import replace
from time import perf_counter

import numpy as np
from logged import Logged, cycle, settings_for
from timing import time_each

from collplan_core.local_map import build_local_map
from collplan_core.paper_planner.trajectory import TIME_LAWS, WAYPOINTS, spline
from collplan_core.parameters import Settings
from collplan_core.sensing.scan_consistency import range_noise
from collplan_core.sensing.wall_lines import on_wall_lines
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan
from omnipuck_sim.trial import run_trial
from omnipuck_sim.trial_record import TrialResult

SHIPPED = Settings()
NOISE = 0.01
"""Standard deviation of a range of a low-cost LIDAR [m]."""


def scan_round(states: list[Logged]) -> list[float]:
    """The scan at each state [us]."""
    return time_each(lambda each: simulate_scan(each.world, each.state, SHIPPED.lidar), states)


def lines_round(states: list[Logged]) -> list[float]:
    """Time from a scan with NOISE on its ranges to the walls that it shows, in each state [us]."""
    random = np.random.default_rng(0)
    errors = NOISE * random.standard_normal((len(states), SHIPPED.lidar.n_beams))
    noisy = [
        replace(state.scan, ranges=np.maximum(state.scan.ranges + each, 0.0))
        for state, each in zip(states, errors, strict=True)
    ]
    return time_each(lambda scan: on_wall_lines(scan, range_noise(scan)), noisy)


def map_round(states: list[Logged]) -> list[float]:
    """Time from a scan to the local map, in each state [us]."""
    return time_each(lambda each: build_local_map(each.scan, each.state, SHIPPED.robot, SHIPPED.local_map), states)


def cycle_round(states: list[Logged], pruned: bool = True) -> list[float]:
    """Time from a scan to the plan, in each state [us]."""
    cases = [(each, settings_for(each.strategy, pruned)) for each in states]
    return time_each(lambda case: cycle(*case), cases)


def trajectory_round(states: list[Logged]) -> list[float]:
    """Time from a state and its plan's aim to the sampled spline, in each state [us]."""
    p = SHIPPED.planner
    law, waypoints = TIME_LAWS[p.time_law](SHIPPED, 0.0), WAYPOINTS[p.waypoints]
    parameter = np.linspace(0.0, 1.0, p.n_samples)

    def trajectory(each: Logged) -> None:
        points, _ = waypoints(each.state.position, each.state.velocity, each.plan.aim, each.plan.aim_velocity, law)
        spline(points, parameter)

    return time_each(trajectory, states)


def trial_round(world: World, seed: int, strategy: str = SHIPPED.planner.strategy) -> tuple[float, TrialResult]:
    """Wall time of a whole run [s], and the run."""
    settings = SHIPPED.with_values({"planner.strategy": strategy})
    begun = perf_counter()
    result = run_trial(world, settings, seed)
    return perf_counter() - begun, result
