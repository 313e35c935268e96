"""Run folders of a simulated robot that drives into the walls of a small room, as bringup writes them."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from bumping_drive import SPEEDS, bumping_drive
from collplan_core.parameters import Settings
from collplan_core.worlds import load_world
from collplan_ros.bringup.main import write_results
from collplan_ros.bringup.options import ROBOTS
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.run_log import PoseRow, RunLog, SentCommand
from made_runs import write_recording

ROOM = "bounds: [0, 0, 3.0, 0.9]\nwalled: true\nstart: [0.4, 0.4]\n"
EPOCH = 1.7e9


def bumping_run(parent: Path, duration: float, seed: int = 0, speeds=SPEEDS, **values: float) -> Path:
    """The folder of a run of `duration` [s], with these parameters (`__` for the dot)."""
    parent.mkdir(parents=True, exist_ok=True)
    (parent / "room.yaml").write_text(ROOM)
    given = {key.replace("__", "."): value for key, value in values.items()}
    world = str(parent / "room.yaml")
    settings = Settings().with_values({"lidar.world": world, "simulator.world": world, **given})
    folder = RunFolder(parent, settings)
    room = load_world(world)
    goal = np.array([2.0, 0.5])
    prepared = Preparation(ROBOTS["sim"], "local", settings, room, goal, {})
    write_recording(folder.path, _driven(settings, duration, seed, speeds), goal, world=room)
    write_results(read_run(folder.path), prepared, "timeout")
    return folder.path


def _driven(settings: Settings, duration: float, seed: int, speeds: tuple[float, float]) -> RunLog:
    log = RunLog()
    for row in bumping_drive(load_world(settings.simulator.world), settings, seed, duration, speeds):
        sent = 77.0 + row.truth.stamp
        pose, truth = row.measured, row.truth
        log.poses.append(PoseRow(EPOCH + pose.stamp, *pose.position.tolist(), pose.yaw, 0.0, 0.0, sent))
        log.truth.append(
            PoseRow(EPOCH + truth.stamp, *truth.position.tolist(), truth.yaw, *truth.velocity.tolist(), sent)
        )
        if row.is_new:
            log.sent_commands.append(SentCommand(sent, *row.command.tolist(), row.turn))
        log.impacts += [replace(hit, time=EPOCH + hit.time) for hit in row.impacts]
    return log
