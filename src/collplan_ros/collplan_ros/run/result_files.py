"""The result files of a run: trajectory, impacts and summary."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from collplan_core.evaluation.machine import machine_verdict
from collplan_core.parameters import Settings
from collplan_core.worlds import World
from collplan_ros.run.impacts import Impacts, impacts_of, write_impacts
from collplan_ros.run.run_log import RunLog
from collplan_ros.run.run_timing import timing_of
from collplan_ros.run.summary import assumed_constants, summarize
from collplan_ros.run.trajectory_file import write_trajectory
from collplan_ros.run.whole_file import replacing

TRAJECTORY, IMPACTS, SUMMARY, PICTURE = "trajectory.csv", "impacts.csv", "summary.json", "trajectory.png"


@dataclass(frozen=True, eq=False)
class Results:
    """Results computed from a run.

    Attributes:
        impacts: impacts of the run.
        summary: content of summary.json.
    """

    impacts: Impacts
    summary: dict[str, Any]


def write_result_files(
    folder: Path,
    log: RunLog,
    world: World,
    goal: np.ndarray,
    settings: Settings,
    outcome: str,
    said: Mapping[str, Any],
) -> Results:
    """Writes trajectory, impacts and summary of a run, each of them whole, the trajectory first.

    Args:
        folder: folder for the files.
        log: log of the run.
        world: world of the run.
        goal: (2,) [m].
        settings: its parameters.
        outcome: its outcome.
        said: further values of the summary.

    Raises:
        RecordError: a file cannot be written.
    """
    with replacing(folder / TRAJECTORY) as path:
        write_trajectory(path, log)
    impacts = impacts_of(log, settings.mocap.velocity_window)
    with replacing(folder / IMPACTS) as path:
        write_impacts(path, impacts, log.begin)
    timing = timing_of(log)
    summary = {
        "simulated": log.simulated,
        "world": settings.simulator.world,
        "seed": settings.simulator.seed,
        **summarize(log, impacts, outcome, goal, settings),
        "real_time_factor": timing.factor,
        "longest_gap_s": timing.gap,
        "machine": machine_verdict(timing, settings.simulator.speed_factor, settings.limits.command_age),
        **said,
        "assumed": assumed_constants(settings, log.simulated),
    }
    with replacing(folder / SUMMARY) as path:
        path.write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n")
    return Results(impacts, summary)
