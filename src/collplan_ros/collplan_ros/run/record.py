"""The record of a run from its log, and its impacts in a file."""

import csv
import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from collplan_core.evaluation.impact_matching import Prediction
from collplan_core.evaluation.run_record import RunRecord
from collplan_core.impact import Impact
from collplan_ros.run.run_log import PoseRow, RunLog

SETTLED = 1.1
"""So long after an impact a velocity is fitted to poses after it alone, in velocity_windows."""
VECTORS = ("x", "y", "normal_x", "normal_y", "before_vx", "before_vy", "after_vx", "after_vy")
COLUMNS = ("t", *VECTORS, "direction_error", "foreseen", "deliberate")


def record_of(log: RunLog, velocity_window: float) -> RunRecord:
    """The record of a run. The velocity after a measured impact is that which poses show later, and so better.

    `velocity_window` is mocap.velocity_window, over which velocities of measured poses are fitted [s].
    """
    impacts = log.own_impacts if log.poses else []
    if not log.truth:
        impacts = [
            replace(each, velocity_after=_settled(each, impacts, log.poses, velocity_window)) for each in impacts
        ]
    begin, sent = log.time_zero, [each.sent for each in log.sent_commands if log.poses]
    track = [(row.stamp, *row[1:3], *row[4:6]) for row in log.track if begin is not None and begin <= row.stamp]
    commands = [(log.stamp_at(each.sent), *each[1:]) for each in log.sent_commands if log.poses]
    return RunRecord(
        begin=begin,
        arrived=log.arrival if log.poses else math.nan,
        track=np.array(track).reshape(-1, 5),
        is_true=bool(log.truth),
        impacts=tuple(impacts),
        predictions=[Prediction(made, contacts) for made, contacts in sorted(log.plans.items())],
        planning_times=log.figure("planning_time_ms"),
        candidates=log.figure("candidates"),
        candidates_before_pruning=log.figure("candidates_before_pruning"),
        commands=np.array(commands).reshape(-1, 4),
        # the controller names a new maneuver just after the command that begins it
        commanded=[log.maneuver_at(end) for end in [*sent[1:], math.inf][: len(sent)]],
        sent=np.array(sent),
    )


def _settled(impact: Impact, impacts: Sequence[Impact], poses: list[PoseRow], velocity_window: float) -> np.ndarray:
    """Velocity after a measured impact: of the first pose fitted to later ones alone, or the last before the next."""
    later = min((other.time for other in impacts if other.time > impact.time), default=math.inf)
    settled = min(_first_from(impact.time + SETTLED * velocity_window, poses), _first_from(later, poses) - 1)
    row = poses[max(settled, 0)]
    return np.array([row.vx, row.vy])


def _first_from(stamp: float, track: list[PoseRow]) -> int:
    """Returns the index of the first pose at or after a stamp [s]."""
    return bisect_left(track, stamp, key=lambda row: row.stamp)


def write_impacts(path: Path, record: RunRecord, begin: float) -> None:
    """Writes one row per impact; t counts from `begin` [s], as in trajectory.csv."""
    verdicts = record.verdicts
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for each, error, *kinds in zip(
            record.impacts, verdicts.rebounds[:, 0], verdicts.foreseen, verdicts.deliberate, strict=True
        ):
            vectors = each.point, each.normal, each.velocity_before, each.velocity_after
            numbers = [each.time - begin, *np.concatenate(vectors), error]
            writer.writerow([*(f"{number:.6f}" for number in numbers), *(str(bool(kind)).lower() for kind in kinds)])


def counted_impacts(number: int) -> str:
    """Number of impacts in words: "1 impact", "2 impacts"."""
    return f"{number} impact{'' if number == 1 else 's'}"
