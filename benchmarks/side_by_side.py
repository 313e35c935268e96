"""Comparisons with peers: rounds of ours and theirs are interleaved in one run."""

from dataclasses import replace
from typing import Any

import numpy as np
from dwa_settings import DWA_SETTINGS, dwa_query
from logged import Logged
from ours import cycle_round, scan_round, trial_round
from peer import Peer
from timing import Timed, ratio, ratio_of

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan


def beside_irsim_scan(peer: Peer, world: World, states: list[Logged], rounds: int) -> dict[str, Any]:
    """Time of simulate_scan over that of Lidar2D.step: 360 beams, no noise, same scene and poses."""
    angles = _load_world(peer, world)
    poses = [[*state.state.position.tolist(), 0.0] for state in states]
    peer.ask("scan", poses=poses[:10])
    ours, theirs = Timed(), Timed()
    for _ in range(rounds):
        ours.rounds.append(scan_round(states))
        answer = peer.ask("scan", poses=poses)
        theirs.rounds.append(answer["us"])
    difference = _range_difference(world, states[-1], angles, np.array(answer["ranges"]))
    return {**ratio(ours, theirs), "ours": ours.summary(), "peer": theirs.summary(), "largest_difference_m": difference}


def _load_world(peer: Peer, world: World) -> np.ndarray:
    """Loads a world, walled and without circles, into the peer; returns the directions of its beams (n,) [rad]."""
    assert world.start is not None
    assert world.goal is not None
    robot = Settings().robot
    answer = peer.ask(
        "world",
        radius=robot.radius,
        max_speed=robot.max_speed,
        world={
            "bounds": list(world.bounds),
            "polygons": [polygon.tolist() for polygon in world.polygons],
            "start": world.start.tolist(),
            "goal": world.goal.tolist(),
        },
    )
    return np.array(answer["angles"])


def _range_difference(world: World, state: Logged, angles: np.ndarray, ranges: np.ndarray) -> float:
    """Largest difference of the ranges along the peer's beams [m], which shows that both scan the same scene."""
    # the peer's last beam may repeat its first
    n = round(2 * np.pi / (angles[1] - angles[0]))
    lidar = replace(Settings().lidar, n_beams=n, angle_min=float(angles[0]))
    ours = simulate_scan(world, replace(state.state, yaw=0.0), lidar).ranges
    return float(np.abs(np.clip(ours, lidar.range_min, lidar.range_max) - ranges[:n]).max())


def beside_dwa(peer: Peer, states: list[Logged], rounds: int) -> dict[str, Any]:
    """Time of a cycle from scan to plan over that of a dynamic-window step on the scan's points, in the same states."""
    queries = [dwa_query(state) for state in states]
    peer.ask("dwa", settings=DWA_SETTINGS, queries=queries[:1])
    ours, theirs = Timed(), Timed()
    for _ in range(rounds):
        ours.rounds.append(cycle_round(states))
        answer = peer.ask("dwa", settings=DWA_SETTINGS, queries=queries)
        theirs.rounds.append(answer["us"])
    our_candidates = [len(state.plan.candidates.costs) for state in states]
    return {
        **ratio(ours, theirs),
        "ours": ours.summary(),
        "peer": theirs.summary(),
        "candidates": {"ours": float(np.mean(our_candidates)), "peer": float(np.mean(answer["candidates"]))},
        "us_per_candidate": {
            "ours": _per_candidate(ours, our_candidates),
            "peer": _per_candidate(theirs, answer["candidates"]),
        },
    }


def _per_candidate(timed: Timed, candidates: list[int]) -> float:
    """Total time of the steps over the total number of their candidates [us]."""
    return round(float(timed.all.sum() / (len(timed.rounds) * sum(candidates))), 4)


def beside_irsim_trial(peer: Peer, world: World, step_time: float, rounds: int) -> dict[str, Any]:
    """Wall time of a run over that of moving ir-sim's robot with its LIDAR along the same path."""
    _load_world(peer, world)
    ours, theirs, steps = [], [], 0
    for seed in range(rounds):
        wall, run = trial_round(world, seed)
        stride = round(step_time * Settings().simulator.mocap_rate)
        answer = peer.ask("trial", path=run.trajectory[::stride, 1:3].tolist(), step_time=step_time)
        ours.append(wall)
        theirs.append(answer["s"])
        steps += answer["steps"]
    return {
        **ratio_of(ours, theirs),
        "ours_s": float(np.median(ours)),
        "peer_s": float(np.median(theirs)),
        "peer_step_s": step_time,
        "peer_steps": steps,
        "rounds": rounds,
    }
