"""Run folders of a simulated robot that drives into the walls of a small room, as bringup writes them."""

from pathlib import Path

import numpy as np

from collplan_core.parameters import Settings
from collplan_core.worlds import load_world
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation, write_used_parameters
from collplan_ros.bringup.results import write_results
from collplan_ros.bringup.robots import ROBOTS
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.runs.run_log import ImpactRecord, PoseRow, RunLog, SentCommand
from omnipuck_sim.robot.physics import Simulator

ROOM = "bounds: [0, 0, 1.6, 1.2]\nwalled: true\ncircles:\n  - {center: [0.8, 0.6], radius: 0.1}\nstart: [0.4, 0.4]\n"
EPOCH = 1.7e9
STRETCH = 0.6
"""One direction is commanded for so long [s]."""
MOCAP_STEPS, COMMAND_STEPS = 4, 20
"""Steps of the physics at 400 Hz between two poses, and between two commands."""


def bumping_run(parent: Path, duration: float, seed: int = 0, speeds=(0.4, 1.1), **values: float) -> Path:
    """The folder of a run of `duration` [s], with these parameters (`__` for the dot)."""
    parent.mkdir(parents=True, exist_ok=True)
    (parent / "room.yaml").write_text(ROOM)
    given = {key.replace("__", "."): value for key, value in values.items()}
    world = str(parent / "room.yaml")
    settings = Settings().with_values({"lidar.world": world, "simulator.world": world, **given})
    folder = RunFolder(parent)
    write_used_parameters(folder.parameters, settings)
    room = load_world(world)
    prepared = Preparation(ROBOTS["sim"], "local", settings, room, np.array([1.2, 0.8]), {})
    write_results(folder, _driven(settings, duration, seed, speeds), prepared, "timeout", Options(pictures=False))
    return folder.path


def _driven(settings: Settings, duration: float, seed: int, speeds: tuple[float, float]) -> RunLog:
    random, log = np.random.default_rng(seed), RunLog()
    simulator = Simulator(load_world(settings.simulator.world), settings, seed)
    velocity = np.zeros(2)
    for step in range(round(400 * duration)):
        sent = 77.0 + simulator.time
        if step % MOCAP_STEPS == 0:
            _record(log, simulator, sent)
        if step % round(400 * STRETCH) == 0:
            angle = random.uniform(-np.pi, np.pi)
            velocity = random.uniform(*speeds) * np.array([np.cos(angle), np.sin(angle)])
        if step % COMMAND_STEPS == 0:
            simulator.command(velocity, 0.0)
            log.sent_commands.append(SentCommand(sent, *velocity.tolist(), 0.0))
        simulator.step()
    for hit in simulator.take_impacts():
        log.true_impacts.append(ImpactRecord(EPOCH + hit.time, *(hit.velocity_after - hit.velocity_before).tolist()))
    return log


def _record(log: RunLog, simulator: Simulator, sent: float) -> None:
    pose, truth = simulator.measured_pose(), simulator.state
    log.poses.append(PoseRow(EPOCH + pose.stamp, *pose.position.tolist(), pose.yaw, 0.0, 0.0, sent))
    log.truth.append(PoseRow(EPOCH + truth.stamp, *truth.position.tolist(), truth.yaw, *truth.velocity.tolist(), sent))
