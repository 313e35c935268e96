"""Result files of a run."""

import shlex
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from collplan_core.command_line import as_called
from collplan_core.worlds import UNKNOWN, World
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.run.description import PARAMETERS
from collplan_ros.run.recorded_run import RecordedRun
from collplan_ros.run.result_files import PICTURE, Results, write_result_files
from collplan_ros.run.run_log import RunLog
from collplan_ros.run.whole_file import replacing

BESIDE = 0.8
"""Shown of an unknown world beside the robot's way [m]."""


def write_results(run: RecordedRun, preparation: Preparation, outcome: str, reason: str = "") -> Results:
    """Writes trajectory, impacts and summary of a run, each of them whole, the trajectory first.

    `reason` explains its end; empty where the outcome suffices.

    Raises:
        RecordError: a file cannot be written.
    """
    settings, world, goal = preparation.settings, preparation.world, preparation.goal
    said = {"reason": reason, "repeat": repeating(preparation.asked, run.folder / PARAMETERS, goal)}
    return write_result_files(run.folder, run.log, world, goal, settings, outcome, said)


def repeating(asked: Sequence[str], parameters: Path, goal: np.ndarray) -> str:
    """Returns the command line that repeats a run to a goal (2,) [m], with options `asked` beside its parameters."""
    # argparse takes -1e-05 for an option
    x, y = (np.format_float_positional(value, trim="0") for value in goal)
    return shlex.join([as_called("bringup"), *asked, "--params", str(parameters), "--goal", x, y])


def make_pictures(run: RecordedRun, results: Results, preparation: Preparation) -> list[str]:
    """Draws trajectory.png and writes run.html, of a run with poses; returns why one of them is missing."""

    def picture() -> None:
        from collplan_ros.run.picture.title import run_end, run_title
        from collplan_ros.run.picture.trajectory_png import draw_trajectory

        log, goal, settings = run.log, preparation.goal, preparation.settings
        world = _drawn(preparation.world, log, goal)
        title = f"{run_title(world, settings, preparation.robot.simulated)}\n{run_end(results.summary)}"
        with replacing(run.folder / PICTURE) as path:
            draw_trajectory(path, log, results.impacts, world, goal, settings, title)

    def page() -> None:
        from collplan_ros.run.page import write_run_page

        write_run_page(run)

    missing = []
    # what they import is slow to load
    for name, make in ((PICTURE, picture), ("run.html", page)) if run.log.poses else ():
        try:
            make()
        except Exception as error:  # whatever it is: the run is over, and its figures are written
            missing.append(f"{name} not made: {type(error).__name__}: {error}")
    return missing


def _drawn(world: World, log: RunLog, goal: np.ndarray) -> World:
    """Returns the world of a picture; for an unknown one, bounds around the robot's way and its goal (2,) [m]."""
    if world.name != UNKNOWN:
        return world
    places = np.vstack([goal, *((pose.x, pose.y) for pose in log.poses)])
    low, high = (places.min(axis=0) - BESIDE).tolist(), (places.max(axis=0) + BESIDE).tolist()
    return replace(world, bounds=(*low, *high))
