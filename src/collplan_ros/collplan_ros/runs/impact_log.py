"""The impacts of a run: where on the obstacles they were, whether a plan foresaw them, and how well."""

import csv
import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from collplan_core.evaluation.impact_matching import (
    Prediction,
    deliberate_impacts,
    foreseen_impacts,
    foreseen_rebounds,
)
from collplan_core.plane import nearest_on_segment
from collplan_core.worlds import World, world_segments
from collplan_ros.runs.run_log import ImpactRecord, PoseRow, RunLog

VECTORS = ("x", "y", "normal_x", "normal_y", "before_vx", "before_vy", "after_vx", "after_vy")
SLACK = 1e-4
"""Stamps are not evenly spaced to the last digit [s]."""
COLUMNS = ("t", *VECTORS, "direction_error", "foreseen", "deliberate")


@dataclass(frozen=True, eq=False)
class Impacts:
    """The impacts of a run, world frame, in order of time.

    Of a simulated robot: contacts begun at more than 0.08 m/s into the wall; contacts within 50 ms of one on the same
    surface belong to it. Of a real robot: the impacts that were detected.

    Attributes:
        times: (k,) [s], of detection where the robot is real.
        points: (k, 2) on the obstacle [m].
        normals: (k, 2) unit normals out of the obstacle.
        before: (k, 2) velocity before each impact [m/s].
        after: (k, 2) velocity after each impact [m/s].
        direction_errors: (k,) angle in [0, pi] between the velocity after an impact and the one that the last plan
            before it foresaw [rad]; NaN where that plan foresaw no such impact.
        foreseen: (k,) whether a plan in force foresaw the impact.
    """

    times: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    before: np.ndarray
    after: np.ndarray
    direction_errors: np.ndarray
    foreseen: np.ndarray

    def __len__(self) -> int:
        return len(self.times)

    @property
    def deliberate(self) -> np.ndarray:
        """(k,) whether each impact was foreseen, and faster into the wall than a graze."""
        return deliberate_impacts(self.foreseen, -(self.before * self.normals).sum(axis=1))


def impacts_of(log: RunLog, world: World, velocity_window: float) -> Impacts:
    """The impacts of a run, each on the surface of `world` that was nearest to the robot.

    Args:
        log: the run.
        world: the world that the robot was in.
        velocity_window: mocap.velocity_window, over which velocities of measured poses are fitted [s].
    """
    rows = np.array([_row(impact, log, world, velocity_window) for impact in log.impacts]).reshape(-1, 9)
    times, points, normals, before, after = rows[:, 0], rows[:, 1:3], rows[:, 3:5], rows[:, 5:7], rows[:, 7:9]
    predictions = [Prediction(made, contacts) for made, contacts in sorted(log.contacts.items())]
    errors = foreseen_rebounds(times, points, after, predictions)[:, 0]
    return Impacts(times, points, normals, before, after, errors, foreseen_impacts(times, points, predictions))


def _row(impact: ImpactRecord, log: RunLog, world: World, velocity_window: float) -> list[float]:
    """Time, point, normal, velocity before and velocity after of an impact."""
    if log.truth:
        position, before, after = _true_motion(impact, log)
    else:
        position, before, after = _measured_motion(impact, log, velocity_window)
    point, normal = nearest_surface(world, position)
    return [impact.stamp, *point, *normal, *before, *after]


def _true_motion(impact: ImpactRecord, log: RunLog) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity before and velocity after (2,) of a true impact, between two true poses."""
    last, following = _poses_around(impact.stamp, log.truth)
    within = [other for other in log.impacts if last.stamp <= other.stamp < following.stamp]
    earlier = _total_change(other for other in within if other.stamp < impact.stamp)
    # the change that the impacts between the poses do not explain is the wheels' doing, spread evenly
    driven = _velocity(following) - _velocity(last) - _total_change(within)
    elapsed, interval = impact.stamp - last.stamp, following.stamp - last.stamp
    before = _velocity(last) + earlier + (elapsed / interval if interval > 0.0 else 0.0) * driven
    return _position(last) + before * elapsed, before, before + _change(impact)


def _measured_motion(
    impact: ImpactRecord, log: RunLog, velocity_window: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position, velocity before and velocity after (2,) of a detected impact.

    The velocity after it is that of the last pose within `velocity_window` [s] and before the next impact, as that of
    earlier poses is fitted to few points.
    """
    stamps = [row.stamp for row in log.poses]
    later = min((other.stamp for other in log.impacts if other.stamp > impact.stamp), default=math.inf)
    settled = min(np.searchsorted(stamps, impact.stamp + velocity_window + SLACK), np.searchsorted(stamps, later)) - 1
    after = _velocity(log.poses[max(int(settled), 0)])
    last, _ = _poses_around(impact.stamp, log.poses)
    if last.stamp == impact.stamp:
        # found in the poses: this pose's velocity is already the one after it, with the error of the change
        return _position(last), _velocity(last) - _change(impact), after
    return _position(last) + _velocity(last) * (impact.stamp - last.stamp), _velocity(last), after


def _change(impact: ImpactRecord) -> np.ndarray:
    return np.array([impact.dvx, impact.dvy])


def _total_change(impacts: Iterable[ImpactRecord]) -> np.ndarray:
    return np.array([_change(impact) for impact in impacts]).reshape(-1, 2).sum(axis=0)


def _position(row: PoseRow) -> np.ndarray:
    return np.array([row.x, row.y])


def _velocity(row: PoseRow) -> np.ndarray:
    return np.array([row.vx, row.vy])


def _poses_around(stamp: float, track: list[PoseRow]) -> tuple[PoseRow, PoseRow]:
    """The last pose up to a stamp [s] and the first one after it."""
    following = int(np.searchsorted([row.stamp for row in track], stamp, side="right"))
    return track[max(following - 1, 0)], track[min(following, len(track) - 1)]


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
    """Writes impacts.csv, one row per impact; t counts from `begin` [s], as in trajectory.csv."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for i in range(len(impacts)):
            vectors = (impacts.points[i], impacts.normals[i], impacts.before[i], impacts.after[i])
            numbers = [impacts.times[i] - begin, *np.concatenate(vectors), impacts.direction_errors[i]]
            kinds = (impacts.foreseen[i], impacts.deliberate[i])
            writer.writerow([*(f"{number:.6f}" for number in numbers), *(str(bool(kind)).lower() for kind in kinds)])
