"""What walks into the way of a robot that drives: whole runs of bringup, read from their recordings."""

import tempfile
from pathlib import Path
from random import Random

import numpy as np
import yaml
from bringup_process import Run

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_ros.messages.reading import movers_from_markers
from collplan_ros.run.reader import raw_messages
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.writer import RECORDING
from faults.runner import Bench, Fault, Measured

STILL = 0.10
"""The robot's own speed towards a mover up to which a touch is none in motion, as in `make movers` [m/s]."""
REACH = "/**:\n  ros__parameters:\n    lidar: {range_max: 13.0}\n"
"""Of the LIDAR: what moves is found only where a beam met something before."""
HALL = {"bounds": [-1.0, -2.5, 11.0, 2.5], "start": [0.0, 0.0], "goal": [9.0, 0.0]}
AT, FROM = (2.5, 5.0, 7.5), 2.2
"""Where movers cross the way, which none turns on, and how far beside it they begin at most, and go beyond it [m]."""
SPEEDS, RADII = (0.3, 0.8), (0.08, 0.13)
"""[m/s], [m]"""
COMES, SETS_OUT, SPREAD = {"avoid": 1.1, "bounce": 1.1, "low_risk": 0.85}, 0.5, 0.7
"""The speed [m/s] by strategy and the start [s] that tell when the robot comes; a mover is so much off that [s]."""
ARRIVES = 20.0
"""Longest time from the first command to the goal: twice that at 0.9 m/s without movers [s]."""
NEAR = 0.5
"""A mover that came no nearer was not in its way [m]."""


def scene(chance: Random, comes: float) -> dict:
    """A hall in which movers cross the way, each about when a robot of this speed [m/s] comes."""
    movers = []
    for x in AT:
        speed, side = chance.uniform(*SPEEDS), chance.choice((-1.0, 1.0))
        crosses = SETS_OUT + x / comes + chance.uniform(-SPREAD, SPREAD)
        begin = min(FROM, speed * crosses)
        way = [[x, -side * begin], [x, side * FROM]]
        delay = max(0.0, crosses - begin / speed)
        radius = chance.uniform(*RADII)
        movers.append({"radius": radius, "way": way, "speed": speed, "delay": delay, "to_and_fro": False})
    return {**HALL, "movers": movers}


def crossed(bench: Bench, folder: Path) -> Measured:
    """The time to the goal; a miss where the robot touches a mover while it drives towards it, or does not arrive."""
    strategy, comes = bench.chance.choice(tuple(COMES.items()))
    world, parameters = folder / "crossing.yaml", folder / "reach.yaml"
    world.write_text(yaml.safe_dump(scene(bench.chance, comes)), encoding="utf-8")
    parameters.write_text(REACH, encoding="utf-8")
    options = "--no-pictures", "--world", str(world), "--params", str(parameters), "--strategy", strategy
    with Run(folder / "runs", *options) as run:
        run.end()
    recording = run.out / "latest" / RECORDING
    if not recording.exists():
        return Measured(missed=f"bringup did not drive: {run.text[-300:]}")
    gap = nearest(recording)
    if gap > NEAR:
        return Measured(unbegun=f"no mover came nearer than {gap:.1f} m")
    summary, log = run.summary(), read_run(run.out / "latest").log
    fastest = max((impact.speed_into for impact in log.impacts if impact.with_mover), default=0.0)
    touched = f"{strategy} touches a mover at {fastest:.2f} m/s of its own" if fastest > STILL else ""
    ended = "" if summary["outcome"] == REACHED else f"{strategy} ends as {summary['outcome']}"
    top = max(float(np.hypot(pose.vx, pose.vy)) for pose in log.truth)
    return Measured(summary["arrival_time_s"], touched or ended, speed=top)


def in_folder(bench: Bench, nothing: None) -> Measured:
    with tempfile.TemporaryDirectory(prefix="faults-", ignore_cleanup_errors=True) as folder:
        return crossed(bench, Path(folder))


def nearest(recording: Path) -> float:
    """How near a mover came to the robot [m]."""
    gaps, movers, frame = [np.inf], np.zeros((0, 5)), Settings().frames.map
    for message in raw_messages(recording, ("ground_truth/odom", "ground_truth/movers")):
        if message.topic == "ground_truth/movers":
            _, movers = movers_from_markers(message.decoded, frame)
        else:
            here = message.decoded.pose.pose.position
            gaps += (np.hypot(movers[:, 0] - here.x, movers[:, 1] - here.y) - movers[:, 4]).tolist()
    return min(gaps) - Settings().robot.radius


FAULTS = [
    Fault(
        f"movers cross its way, three a run: no touch at over {STILL:g} m/s of its own; time to the goal",
        "process",
        ARRIVES,
        lambda bench: None,
        in_folder,
    )
]
