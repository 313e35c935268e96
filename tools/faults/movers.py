"""What walks into the way of a robot that drives: whole runs of bringup, read from their recordings."""

from itertools import pairwise
from pathlib import Path
from random import Random

import numpy as np
import yaml
from bringup_process import Run

from collplan_core.evaluation.run_end import REACHED
from collplan_core.parameters import Settings
from collplan_ros.messages.mover_reading import movers_from_markers
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.run.reader import raw_messages
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.writer import RECORDING
from faults.fault import Fault, Measured
from faults.runs import in_folder, nothing

STILL = 0.10
"""The robot's own speed towards a mover up to which a touch is none in motion, as in `make movers` [m/s]."""
REACH = """
/**:
  ros__parameters:
    lidar: {range_max: 13.0}
"""
"""Of the LIDAR: what moves is found only where a beam met something before."""
HALL = {"bounds": [-1.0, -2.5, 11.0, 2.5], "start": [0.0, 0.0], "goal": [9.0, 0.0]}
AT = 2.5, 5.0, 7.5
"""Where movers cross the way; nothing hides one from the start on, and none turns [m]."""
FROM = 2.2
"""So far beside the way they begin at most, and go beyond it [m]."""
SPEEDS, RADII = (0.3, 0.8), (0.08, 0.13)
"""[m/s], [m]"""
COMES = {"avoid": 1.1, "bounce": 1.1, "low_risk": 0.85}
"""Strategies, and the speed by which it is told when the robot comes [m/s]."""
SETS_OUT = 0.5
"""When it would have begun with that speed, by the simulated clock [s]."""
SPREAD = 0.7
"""A mover crosses the way so long before or after that at most [s]."""
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
        each = {"radius": chance.uniform(*RADII), "way": way, "speed": speed, "delay": delay, "to_and_fro": False}
        movers.append(each)
    return {**HALL, "movers": movers}


def crossed(folder: Path, chance: Random) -> Measured:
    """The time to the goal; a miss where the robot touches a mover while it drives towards it, or does not arrive."""
    strategy, comes = chance.choice(tuple(COMES.items()))
    world, parameters = folder / "crossing.yaml", folder / "reach.yaml"
    world.write_text(yaml.safe_dump(scene(chance, comes)), encoding="utf-8")
    parameters.write_text(REACH, encoding="utf-8")
    options = "--no-pictures", "--world", str(world), "--params", str(parameters), "--strategy", strategy
    with Run(folder / "runs", *options) as run:
        run.end()
    recording = run.out / "latest" / RECORDING
    if not recording.exists():
        return Measured(missed=f"bringup did not drive: {run.text[-300:]}")
    nearest, touches = meetings(recording)
    if nearest > NEAR:
        return Measured(unbegun=f"no mover came nearer than {nearest:.1f} m")
    summary, fastest = run.summary(), max(touches, default=0.0)
    wrong = {
        f"{strategy} touches a mover at {fastest:.2f} m/s of its own": fastest > STILL,
        f"{strategy} ends as {summary['outcome']}": summary["outcome"] != REACHED,
    }
    missed = ", ".join(words for words, is_so in wrong.items() if is_so)
    top = max(np.hypot(pose.vx, pose.vy) for pose in read_run(run.out / "latest").log.truth)
    return Measured(summary["arrival_time_s"], missed, speed=float(top))


def meetings(path: Path) -> tuple[float, list[float]]:
    """How near a mover came in a recording [m], and the robot's own speed towards it at each touch [m/s].

    Poses are 0.01 s apart: robot and mover are taken to go straight on to the next one.
    """
    frames, radius = Settings().frames, Settings().robot.radius
    states, movers = [], {}
    for message in raw_messages(path, ("ground_truth/odom", "ground_truth/movers")):
        if message.topic == "ground_truth/odom":
            states.append(state_from_bytes(message.data, frames.map, frames.base))
        else:
            stamp, rows = movers_from_markers(message.decoded, frames.map)
            movers[stamp] = rows
    nearest, touches = np.inf, []
    for state, following in pairwise(states):
        rows = movers.get(state.stamp, np.zeros((0, 5)))
        apart, relative = rows[:, :2] - state.position, rows[:, 2:4] - state.velocity
        square = np.maximum((relative**2).sum(axis=1), 1e-9)
        later = np.clip(-(apart * relative).sum(axis=1) / square, 0.0, following.stamp - state.stamp)
        gaps = np.hypot(*(apart + later[:, None] * relative).T) - rows[:, 4] - radius
        towards = apart @ state.velocity / np.hypot(*apart.T)
        nearest = min(nearest, *gaps.tolist(), np.inf)
        touches += towards[gaps <= 0.0].tolist()
    return nearest, touches


FAULTS = [
    Fault(
        f"movers cross its way, three a run: no touch at over {STILL:g} m/s of its own; time to the goal",
        "process",
        ARRIVES,
        nothing,
        in_folder(crossed),
    )
]
