"""Scans that lie, and a robot that is stuck, in trials: the closed loop without ROS, whose clock no machine stalls."""

from collections.abc import Callable

import numpy as np
import pytest
from lying_scans import LIES, watched_trial

from collplan_core.loop.decisions import Decision, Notice
from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.worlds import World, parse_world
from faults.bench import Bench
from faults.fault import Fault, Measured
from omnipuck_sim import trial

FAMILIES = ("corridor", "random", "serpentine", "u", "l", "z", "baffles", "pillars")
STRATEGY = "avoid"
SCAN = map_period_of(Settings().with_values({"planner.strategy": STRATEGY}).planner) + 0.2
"""Longest time from the first scan that lies to the robot's standing [s]."""
STUCK = 1.0
"""Longest time from when the robot last moved, commanded to, until the planner says so [s]."""
MOVED = 0.02
"""A robot has moved where it is farther from where it is now than this [m]."""
ROOM = {"bounds": [0.0, 0.0, 3.0, 1.6], "start": [0.3, 0.8], "goal": [2.7, 0.8]}
SCANS = {
    "nothing near": "every beam +Inf",
    "half empty": "half of the beams +Inf",
    "frozen": "frozen to the last bit",
    "lost": "60 % of the beams NaN",
    "late 0.3 s unnoticed": "0.3 s old, stamped as new",
    "late 0.5 s": "0.5 s late by their stamps",
}


def world(seed: int) -> str:
    """The world of a seed, a family after the other."""
    family = FAMILIES[seed % len(FAMILIES)]
    return family if family == "corridor" else f"{family}:{seed}"


def seed_of(bench: Bench) -> int:
    """A seed of its own for each case of a fault, from 0 on."""
    return bench.number


def lying(name: str) -> Callable[[object, int], Measured]:
    def measure(bench: object, seed: int) -> Measured:
        watched = watched_trial(LIES[name], world(seed), STRATEGY, seed, **{"trial.stuck_time": 1.0})
        if not np.isfinite(watched.begun):
            return Measured(unbegun=f"seed {seed} never drove fast enough")
        return Measured(float(watched.stood) if np.isfinite(watched.stood) else None)

    return measure


class Noticed(Exception):
    """The planner has said that the robot is stuck."""


def stuck(bench: object, seed: int) -> Measured:
    """Drives into a wall that the LIDAR does not see, at a place drawn by the seed."""
    x = np.random.default_rng([13, seed]).uniform(1.0, 2.4)
    wall = {"polygons": [[[x, 0.0], [x + 0.1, 0.0], [x + 0.1, 1.6], [x, 1.6]]]}
    path: list[tuple[float, float, float]] = []
    controller, hear = trial.TrialNodes.controller, trial.TrialNodes._hear

    def tick(nodes: trial.TrialNodes) -> None:
        controller(nodes)
        path.append((nodes.simulator.time, *nodes.simulator.state.position.tolist()))

    def watch(nodes: trial.TrialNodes, decision: Decision, local: float) -> None:
        if isinstance(decision, Notice) and decision.text.startswith("stuck at"):
            raise Noticed
        hear(nodes, decision, local)

    settings = Settings().with_values({"planner.strategy": STRATEGY})
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(trial.TrialNodes, "controller", tick)
        patched.setattr(trial.TrialNodes, "_hear", watch)
        try:
            trial.run_trial(room({}), settings, seed, solid=room(wall))
        except Noticed:
            return Measured(still_for(np.array(path)))
    return Measured(None)


def still_for(path: np.ndarray) -> float:
    """For how long the robot has been where it is now, of rows of time, x, y [s, m]."""
    away = np.hypot(*(path[:, 1:] - path[-1, 1:]).T) > MOVED
    return float(path[-1, 0] - path[np.flatnonzero(away)[-1], 0]) if away.any() else float(np.ptp(path[:, 0]))


def room(obstacles: dict) -> World:
    return parse_world({"name": "room", **obstacles, **ROOM}, "room")


FAULTS = [
    *(Fault(f"scan: {words}", "trial", SCAN, seed_of, lying(name), long=30) for name, words in SCANS.items()),
    Fault("stuck at what no sensor sees: until it is noticed", "trial", STUCK, seed_of, stuck),
]
