"""The impacts of a run: where on the world they were, whether a plan foresaw them, and how well."""

import csv
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
from collplan_core.worlds import World, world_segments
from collplan_ros.runs.run_log import ImpactRecord, PoseRow, RunLog

COLUMNS = (
    "t", "x", "y", "normal_x", "normal_y", "before_vx", "before_vy", "after_vx", "after_vy", "direction_error",
    "foreseen", "deliberate",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Impacts:
    """The hits of a run, world frame, in order of time.

    A hit is a contact begun at more than 0.08 m/s into the wall; contacts within 50 ms of it on the same surface
    belong to it.

    Attributes:
        times: (k,) [s].
        points: (k, 2) on the obstacle [m].
        normals: (k, 2) unit normals out of the obstacle.
        before, after: (k, 2) velocity [m/s].
        direction_errors: (k,) angle in [0, pi] between the velocity after it and that in the last plan before it [rad];
            NaN where that one did not foresee it.
        foreseen: (k,) whether a plan in force foresaw it.
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
        """(k,) whether it was foreseen, and faster into the wall than a graze."""
        return deliberate_impacts(self.foreseen, -(self.before * self.normals).sum(axis=1))


def impacts_of(log: RunLog, world: World) -> Impacts:
    """The hits of a run with the surface of `world` that was nearest to the robot at each."""
    rows = np.array([_located(impact_record.stamp, np.array(impact_record[1:]), log, world) for impact_record in log.hits]).reshape(-1, 9)
    times, points, normals, before, after = rows[:, 0], rows[:, 1:3], rows[:, 3:5], rows[:, 5:7], rows[:, 7:9]
    predictions = [Prediction(made, contacts) for made, contacts in sorted(log.contacts.items())]
    errors = foreseen_rebounds(times, points, after, predictions)[:, 0]
    return Impacts(times, points, normals, before, after, errors, foreseen_impacts(times, points, predictions))


def _located(stamp: float, change: np.ndarray, log: RunLog, world: World) -> list[float]:
    sample, following = _samples_around(stamp, log.track)
    within = [impact_record for impact_record in log.hits if sample.stamp <= impact_record.stamp < following.stamp]
    earlier = _total(impact_record for impact_record in within if impact_record.stamp < stamp)
    # what the hits between the samples do not explain, the wheels did, evenly
    driven = np.array(following[4:6]) - np.array(sample[4:6]) - _total(within)
    share = (stamp - sample.stamp) / (following.stamp - sample.stamp) if following.stamp > sample.stamp else 0.0
    before = np.array(sample[4:6]) + earlier + share * driven
    position = np.array(sample[1:3]) + before * (stamp - sample.stamp)
    point, normal = nearest_surface(world, position)
    return [stamp, *point, *normal, *before, *(before + change)]


def _total(impact_records: Iterable[ImpactRecord]) -> np.ndarray:
    return np.array([impact_record[1:] for impact_record in impact_records]).reshape(-1, 2).sum(axis=0)


def _samples_around(stamp: float, track: list[PoseRow]) -> tuple[PoseRow, PoseRow]:
    following = int(np.searchsorted([row.stamp for row in track], stamp, side="right"))
    return track[max(following - 1, 0)], track[min(following, len(track) - 1)]


def nearest_surface(world: World, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The point (2,) of the world's surfaces nearest to a free position (2,) [m], and the unit normal (2,) there."""
    segments = world_segments(world)
    points = _nearest_on_segments(segments, position) if len(segments) else np.zeros((0, 2))
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


def _nearest_on_segments(segments: np.ndarray, position: np.ndarray) -> np.ndarray:
    begin, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    share = ((position - begin) * along).sum(axis=1) / (along * along).sum(axis=1)
    return begin + np.clip(share, 0.0, 1.0)[:, None] * along


def write_impacts(path: Path, impacts: Impacts, begin: float) -> None:
    """Writes impacts.csv, one row per hit; t counts from `begin`, like the trajectory's."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for i in range(len(impacts)):
            vectors = (impacts.points[i], impacts.normals[i], impacts.before[i], impacts.after[i])
            numbers = [impacts.times[i] - begin, *np.concatenate(vectors), impacts.direction_errors[i]]
            kinds = (impacts.foreseen[i], impacts.deliberate[i])
            writer.writerow([*(f"{number:.6f}" for number in numbers), *(str(bool(kind)).lower() for kind in kinds)])
