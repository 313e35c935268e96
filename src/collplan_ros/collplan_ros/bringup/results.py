"""Result files of a run."""

from dataclasses import replace

import numpy as np

from collplan_core.worlds import UNKNOWN, World
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.run.description import PARAMETERS
from collplan_ros.run.recorded_run import RecordedRun
from collplan_ros.run.result_files import PICTURE, Results, write_result_files
from collplan_ros.run.run_log import RunLog
from collplan_ros.run.whole_file import replacing

BESIDE = 0.8
"""Shown of an unknown world beside the robot's way [m]."""


def write_results(
    run: RecordedRun, preparation: Preparation, outcome: str, options: Options, reason: str = ""
) -> Results:
    """Writes trajectory, impacts and summary of a run, each of them whole, the trajectory first.

    `reason` is why it ended so, in words; empty where the outcome says it all.

    Raises:
        RecordError: a file cannot be written.
    """
    settings, world, goal = preparation.settings, preparation.world, preparation.goal
    said = {"reason": reason, "repeat": options.repeat(goal, run.folder / PARAMETERS)}
    return write_result_files(run.folder, run.log, world, goal, settings, outcome, said)


def draw_picture(run: RecordedRun, results: Results, preparation: Preparation) -> str:
    """Draws trajectory.png of a run with poses; returns why there is none, or ""."""
    if not run.log.poses:
        return ""
    # imported late: slow to load
    from collplan_ros.run.picture.title import run_end, run_title
    from collplan_ros.run.picture.trajectory_png import draw_trajectory

    log, goal, settings = run.log, preparation.goal, preparation.settings
    world = _drawn(preparation.world, log, goal)
    title = run_title(world, settings, preparation.robot.simulated)
    try:
        with replacing(run.folder / PICTURE) as path:
            draw_trajectory(path, log, results.impacts, world, goal, settings, f"{title}\n{run_end(results.summary)}")
    except Exception as error:  # whatever a drawing library finds: the run is over, and its figures are written
        return f"trajectory.png not drawn: {type(error).__name__}: {error}"
    return ""


def _drawn(world: World, log: RunLog, goal: np.ndarray) -> World:
    """The world of a picture: of one that is not known what is around the robot's way and its goal (2,) [m]."""
    if world.name != UNKNOWN:
        return world
    places = np.vstack([goal, *((pose.x, pose.y) for pose in log.poses)])
    low, high = (places.min(axis=0) - BESIDE).tolist(), (places.max(axis=0) + BESIDE).tolist()
    return replace(world, bounds=(*low, *high))


def make_page(run: RecordedRun) -> str:
    """Writes run.html of a run with poses; returns why there is none, or ""."""
    if not run.log.poses:
        return ""
    # imported late: slow to load
    from collplan_ros.run.page import write_run_page

    try:
        write_run_page(run)
    except Exception as error:  # whatever it is: the run is over, and its figures are written
        return f"run.html not written: {type(error).__name__}: {error}"
    return ""
