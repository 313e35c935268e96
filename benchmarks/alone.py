"""Measurements without a peer: times of the stages, pruned beside unpruned, pace of a run."""

import statistics
from functools import partial
from time import perf_counter
from typing import Any

import gymnasium
import numpy as np
from logged import Logged
from ours import cycle_round, lines_round, map_round, scan_round, trajectory_round, trial_round
from timing import Timed, ratio

import collplan_gym  # noqa: F401  # registers the environment
from collplan_core.worlds import World

GYM_STEPS = 200
"""Steps of a round, fewer than an episode has."""


def alone(states: list[Logged], rounds: int) -> dict[str, Any]:
    """Times of scan, walls of a noisy one, map, cycle and trajectory in interleaved rounds, and ratios of these."""
    # with the goal in free space there is nothing to choose or prune: such cycles would lower the times
    states = [state for state in states if state.chooses]
    measures = {
        "scan": scan_round,
        "wall_lines": lines_round,
        "local_map": map_round,
        "cycle_pruned": cycle_round,
        "cycle_unpruned": partial(cycle_round, pruned=False),
        "trajectory": trajectory_round,
    }
    timed = {name: Timed() for name in measures}
    for _ in range(rounds):
        for name, measure in measures.items():
            timed[name].rounds.append(measure(states))
    figures: dict[str, Any] = {name: each.summary() for name, each in timed.items()}
    figures["ratios"] = {
        "cycle_pruned_vs_unpruned": ratio(timed["cycle_pruned"], timed["cycle_unpruned"])["ratio"],
        "wall_lines_vs_cycle": ratio(timed["wall_lines"], timed["cycle_pruned"])["ratio"],
    }
    figures["candidates"] = {
        "pruned": statistics.fmean(len(state.plan.candidates.costs) for state in states),
        "unpruned": statistics.fmean(state.plan.n_before_pruning for state in states),
    }
    return figures


def trials_per_second(world: World, rounds: int) -> dict[str, float]:
    """Whole runs a second, one after the other, by strategy; in the median."""
    return {
        strategy: round(1.0 / statistics.median(trial_round(world, seed, strategy)[0] for seed in range(rounds)), 2)
        for strategy in ("harness", "bounce")
    }


def gym_steps_per_second(world: World, rounds: int) -> float:
    """Steps a second of the environment under one action, in the median; a step is 0.05 s simulated."""
    env = gymnasium.make("collplan/Bounce-v0", world=world)
    rates, action = [], np.array([0.6, 0.3], dtype=np.float32)
    for seed in range(rounds):
        env.reset(seed=seed)
        begun = perf_counter()
        for _ in range(GYM_STEPS):
            env.step(action)
        rates.append(GYM_STEPS / (perf_counter() - begun))
    return round(statistics.median(rates), 1)


def realtime_factor(world: World, rounds: int) -> dict[str, float | int]:
    """Simulated time of a run over its wall time."""
    factors = []
    for seed in range(rounds):
        wall, run = trial_round(world, seed)
        factors.append((run.trajectory[-1, 0]) / wall)
    return {"median": round(statistics.median(factors), 1), "n": len(factors)}
