"""Comparisons with programs of others: rounds of ours and theirs take turns in one run."""

from typing import Any

from answering import Ask
from dwa_settings import DWA_SETTINGS, dwa_query
from logged import Logged
from peer import peer
from timing import compared, in_turn, time_each

from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan
from omnipuck_sim.trial import run_trial

SHIPPED = Settings()
STEPS = {"trial_vs_irsim": 1.0 / SHIPPED.lidar.rate, "trial_vs_irsim_at_pose_rate": 1.0 / SHIPPED.simulator.mocap_rate}
"""Steps of ir-sim's run [s]: the rate of our scans, and of our poses."""


def beside_irsim(world: World, states: list[Logged], rounds: int) -> dict[str, Any]:
    """Scans in states of a world, which is walled and has no circles, and whole runs there, over ir-sim's.

    Raises SkippedError where that cannot be installed or run.
    """
    assert world.start is not None
    assert world.goal is not None
    polygons = [polygon.tolist() for polygon in world.polygons]
    ends = {"start": world.start.tolist(), "goal": world.goal.tolist()}
    described = {"bounds": list(world.bounds), "polygons": polygons, **ends}
    scene = {"world": described, "radius": SHIPPED.robot.radius, "max_speed": SHIPPED.robot.max_speed}
    with peer("ir-sim") as irsim:
        found = {"scan_vs_irsim": _scans(irsim, scene, states, rounds)}
        return found | {name: _runs(irsim, scene, world, step, rounds) for name, step in STEPS.items()}


def _scans(irsim: Ask, scene: dict[str, Any], states: list[Logged], rounds: int) -> dict[str, Any]:
    """Time of simulate_scan over that of Lidar2D.step: 360 beams, no noise, same scene and poses."""
    poses = [[*state.state.position.tolist(), 0.0] for state in states]
    sides = {
        "ours": lambda _: time_each(lambda each: simulate_scan(each.world, each.state, SHIPPED.lidar), states),
        "peer": lambda _: irsim("scan", scene=scene, poses=poses),
    }
    return compared(**in_turn(sides, rounds))


def _runs(irsim: Ask, scene: dict[str, Any], world: World, step: float, rounds: int) -> dict[str, Any]:
    """Time of a run over that of moving ir-sim's robot with its LIDAR along the same path."""
    stride = round(step * SHIPPED.simulator.mocap_rate)
    paths = [run_trial(world, SHIPPED, seed).trajectory[::stride, 1:3].tolist() for seed in range(rounds)]
    sides = {
        "ours": lambda seed: time_each(lambda each: run_trial(world, SHIPPED, each), [seed]),
        "peer": lambda seed: irsim("trial", scene=scene, path=paths[seed], step_time=step),
    }
    return {**compared(**in_turn(sides, rounds)), "peer_step_s": step}


def beside_dwa(states: list[Logged], rounds: int) -> dict[str, Any]:
    """Time of a cycle from scan to plan over that of a dynamic-window step on the scan's points, in the same states.

    Raises SkippedError where that cannot be installed or run.
    """
    queries = [dwa_query(state) for state in states]
    with peer("dynamic-window-approach") as dwa:
        sides = {
            "ours": lambda _: time_each(Logged.plan, states),
            "peer": lambda _: dwa("dwa", settings=DWA_SETTINGS, queries=queries),
        }
        return {"cycle_vs_dwa": compared(**in_turn(sides, rounds))}
