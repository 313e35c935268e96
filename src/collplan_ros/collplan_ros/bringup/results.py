"""Result files of a run."""

from typing import Any

from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.runs.impact_log import impacts_of, write_impacts
from collplan_ros.runs.run_log import RunLog
from collplan_ros.runs.summary import assumed_constants, summarize, write_summary
from collplan_ros.runs.trajectory_file import write_trajectory


def write_results(
    folder: RunFolder, log: RunLog, preparation: Preparation, outcome: str, options: Options
) -> dict[str, Any]:
    """Writes trajectory, impacts, summary and, unless turned off, the pictures of a run; returns the summary."""
    settings, world, goal = preparation.settings, preparation.world, preparation.goal
    impacts = impacts_of(log, world, settings.mocap.velocity_window)
    write_trajectory(folder.trajectory, log)
    write_impacts(folder.impacts, impacts, log.begin)
    simulated = preparation.robot.simulated
    summary = {
        "simulated": simulated,
        "world": settings.simulator.world,
        "seed": settings.simulator.seed,
        **summarize(log, impacts, outcome, goal, settings),
        "repeat": options.repeat(goal, folder.parameters),
        "assumed": assumed_constants(settings, simulated),
    }
    write_summary(folder.summary, summary)
    if options.pictures and log.poses:
        _draw(folder, log, impacts, preparation, summary)
    return summary


def _draw(folder: RunFolder, log: RunLog, impacts: Any, preparation: Preparation, summary: dict[str, Any]) -> None:
    # imported late: both are slow to load
    from collplan_ros.pictures.animation import draw_animation
    from collplan_ros.pictures.trajectory_png import draw_trajectory

    settings, world, goal = preparation.settings, preparation.world, preparation.goal
    draw_trajectory(folder.picture, log, impacts, world, goal, settings, _title(summary))
    draw_animation(folder.animation, log, impacts, world, goal, settings)


def _title(summary: dict[str, Any]) -> str:
    arrival = summary["arrival_time_s"]
    end = f"goal reached in {arrival:.1f} s" if arrival is not None else summary["outcome"].replace("_", " ")
    kind = "simulated" if summary["simulated"] else "measured"
    return (
        f"{summary['world']}, {summary['strategy']}, seed {summary['seed']} ({kind}): "
        f"{end}, {summary['path_length_m']:.2f} m, {counted_impacts(summary['impacts'])}"
    )


def counted_impacts(number: int) -> str:
    """Number of impacts in words: "1 impact", "2 impacts"."""
    return f"{number} impact{'' if number == 1 else 's'}"
