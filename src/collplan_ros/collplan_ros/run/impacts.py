"""The impacts of a run: their place on the obstacles, whether a plan foresaw them, and how well."""

import csv
import math
from bisect import bisect_left
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from collplan_core.evaluation.impact_matching import (
    Prediction,
    Verdicts,
    foreseen_rebounds,
    judge_impacts,
    last_before,
)
from collplan_core.plane import nearest_on_segment
from collplan_core.worlds import World, world_segments
from collplan_ros.run.run_log import PoseRow, RunLog

VECTORS = ("x", "y", "normal_x", "normal_y", "before_vx", "before_vy", "after_vx", "after_vy")
SETTLED = 1.1
"""So long after an impact a velocity is fitted to poses after it alone, in velocity_windows."""
COLUMNS = ("t", *VECTORS, "direction_error", "foreseen", "deliberate")


@dataclass(frozen=True, eq=False)
class Impacts:
    """The impacts of a run, world frame, in order of time.

    Of a simulated robot: those of the simulation, contacts begun at more than 0.08 m/s into the wall; contacts within
    50 ms of one on the same surface belong to it. Of a real robot: the impacts that were detected in the poses or
    sensed by the ring, placed where they were measured.

    Attributes:
        times: (k,) time of each impact, also where it was detected later [s].
        points: (k, 2) on the obstacle [m].
        normals: (k, 2) unit normals out of the obstacle.
        before: (k, 2) velocity before each impact [m/s].
        after: (k, 2) velocity after each impact [m/s].
        direction_errors: (k,) angle in [0, pi] between the velocity after an impact and the one that the last plan
            before it foresaw [rad]; NaN where that plan foresaw no such impact.
        speeds: (k,) speed of each impact into the obstacle [m/s].
        verdicts: which were foreseen, and which deliberate.
    """

    times: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    before: np.ndarray
    after: np.ndarray
    direction_errors: np.ndarray
    speeds: np.ndarray
    verdicts: Verdicts

    def __len__(self) -> int:
        return len(self.times)


def impacts_of(log: RunLog, velocity_window: float) -> Impacts:
    """The impacts of a run.

    Args:
        log: the run.
        velocity_window: mocap.velocity_window, over which velocities of measured poses are fitted [s].
    """
    rows = np.array(log.true_impacts).reshape(-1, 9) if log.truth else _measured_rows(log, velocity_window)
    times, points, normals, before, after = rows[:, 0], rows[:, 1:3], rows[:, 3:5], rows[:, 5:7], rows[:, 7:9]
    predictions = [Prediction(made, contacts) for made, contacts in sorted(log.plans.items())]
    errors = foreseen_rebounds(times, points, after, predictions)[:, 0]
    speeds = -(before * normals).sum(axis=1)
    verdicts = judge_impacts(times, points, speeds, predictions)
    return Impacts(times, points, normals, before, after, errors, speeds, verdicts)


def _measured_rows(log: RunLog, velocity_window: float) -> np.ndarray:
    """(k, 9) time, point, normal, velocity before and velocity after of each detected impact."""
    detected = log.detected_impacts if log.poses else []
    rows = [[*impact, *_measured_velocities(impact.stamp, log, velocity_window)] for impact in detected]
    return np.array(rows).reshape(-1, 9)


def _measured_velocities(impact: float, log: RunLog, velocity_window: float) -> list[float]:
    """Velocity before and velocity after (4,) a detected impact at a stamp [s], as measured poses show them.

    Before it: that of the last pose, as none fitted later is free of the impact. After it: that of the first pose that
    is fitted to poses after it alone, or of the last one before the next impact, or of all, where that is earlier.
    """
    later = min((other.stamp for other in log.detected_impacts if other.stamp > impact), default=math.inf)
    settled = min(_first_from(impact + SETTLED * velocity_window, log.poses), _first_from(later, log.poses) - 1)
    last = last_before(impact, log.poses)
    return [*_velocity(last), *_velocity(log.poses[max(settled, 0)])]


def _velocity(row: PoseRow) -> np.ndarray:
    return np.array([row.vx, row.vy])


def _first_from(stamp: float, track: list[PoseRow]) -> int:
    """Returns the index of the first pose at or after a stamp [s]."""
    return bisect_left(track, stamp, key=lambda row: row.stamp)


def nearest_surface(world: World, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The point (2,) of the world's surfaces nearest to a free position (2,) [m], and the unit normal (2,) there.

    Both are NaN in a world without surfaces.
    """
    on_segments = [nearest_on_segment(*segment, *position) for segment in world_segments(world)]
    points = np.array(on_segments).reshape(-1, 2)
    if len(world.circles):
        outward = position - world.circles[:, :2]
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        points = np.vstack([points, world.circles[:, :2] + outward * world.circles[:, 2:]])
    if len(points) == 0:
        return np.full(2, np.nan), np.full(2, np.nan)
    away = position - points
    distances = np.linalg.norm(away, axis=1)
    nearest = int(distances.argmin())
    return points[nearest], away[nearest] / distances[nearest]


def write_impacts(path: Path, impacts: Impacts, begin: float) -> None:
    """Writes one row per impact; t counts from `begin` [s], as in trajectory.csv."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for i in range(len(impacts)):
            vectors = (impacts.points[i], impacts.normals[i], impacts.before[i], impacts.after[i])
            numbers = [impacts.times[i] - begin, *np.concatenate(vectors), impacts.direction_errors[i]]
            kinds = (impacts.verdicts.foreseen[i], impacts.verdicts.deliberate[i])
            writer.writerow([*(f"{number:.6f}" for number in numbers), *(str(bool(kind)).lower() for kind in kinds)])
