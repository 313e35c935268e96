"""Result files of a run."""

from dataclasses import dataclass
from typing import Any

from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.runs.impact_log import Impacts, impacts_of, write_impacts
from collplan_ros.runs.run_log import RunLog
from collplan_ros.runs.summary import assumed_constants, summarize, write_summary
from collplan_ros.runs.trajectory_file import write_trajectory
from collplan_ros.runs.whole_file import replacing


@dataclass(frozen=True, eq=False)
class Results:
    """What was made of a run.

    Attributes:
        log: the run.
        impacts: its impacts.
        summary: content of summary.json.
    """

    log: RunLog
    impacts: Impacts
    summary: dict[str, Any]


def write_results(folder: RunFolder, log: RunLog, preparation: Preparation, outcome: str, options: Options) -> Results:
    """Writes trajectory, impacts and summary of a run, each of them whole, the trajectory first.

    Raises:
        RecordError: a file cannot be written.
    """
    settings, world, goal = preparation.settings, preparation.world, preparation.goal
    with replacing(folder.trajectory) as path:
        write_trajectory(path, log)
    impacts = impacts_of(log, world, settings.mocap.velocity_window)
    with replacing(folder.impacts) as path:
        write_impacts(path, impacts, log.begin)
    simulated = preparation.robot.simulated
    summary = {
        "simulated": simulated,
        "world": settings.simulator.world,
        "seed": settings.simulator.seed,
        **summarize(log, impacts, outcome, goal, settings),
        "repeat": options.repeat(goal, folder.parameters),
        "assumed": assumed_constants(settings, simulated),
    }
    with replacing(folder.summary) as path:
        write_summary(path, summary)
    return Results(log, impacts, summary)


def draw_pictures(folder: RunFolder, results: Results, preparation: Preparation) -> str:
    """Draws picture and animation of a run with poses; returns why there are none, or ""."""
    if not results.log.poses:
        return ""
    # imported late: both are slow to load
    from collplan_ros.pictures.animation import draw_animation
    from collplan_ros.pictures.title import run_end, run_title
    from collplan_ros.pictures.trajectory_png import draw_trajectory

    log, impacts, goal = results.log, results.impacts, preparation.goal
    settings, world = preparation.settings, preparation.world
    title = run_title(world, settings, preparation.robot.simulated)
    try:
        with replacing(folder.picture) as path:
            draw_trajectory(path, log, impacts, world, goal, settings, f"{title}\n{run_end(results.summary)}")
        if log.scans:
            with replacing(folder.animation) as path:
                draw_animation(path, log, impacts, world, goal, settings, title)
    except Exception as error:  # whatever a drawing library finds: the run is over, and its figures are written
        return f"pictures not drawn: {type(error).__name__}: {error}"
    return ""


def make_page(folder: RunFolder, results: Results) -> str:
    """Writes run.html of a run with poses; returns why there is none, or ""."""
    if not results.log.poses:
        return ""
    # imported late: slow to load
    from collplan_ros.view.player import write_run_page

    try:
        write_run_page(folder.path)
    except Exception as error:  # whatever it is: the run is over, and its figures are written
        return f"run.html not written: {type(error).__name__}: {error}"
    return ""
