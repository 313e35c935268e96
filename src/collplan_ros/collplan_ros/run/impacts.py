"""The impacts of a run: their place on the obstacles, whether a plan foresaw them, and how well."""

import csv
import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from collplan_core.evaluation.impact_matching import Prediction, Verdicts, judge_impacts
from collplan_core.impact import Impact
from collplan_ros.run.run_log import PoseRow, RunLog

SETTLED = 1.1
"""So long after an impact a velocity is fitted to poses after it alone, in velocity_windows."""
VECTORS = ("x", "y", "normal_x", "normal_y", "before_vx", "before_vy", "after_vx", "after_vy")
HARD = 0.3
"""Speed into the obstacle from which a rebound tells the restitution [m/s]."""
COLUMNS = ("t", *VECTORS, "direction_error", "foreseen", "deliberate")


@dataclass(frozen=True, eq=False)
class JudgedImpacts:
    """The impacts of a run, world frame, in order of time.

    Of a simulated robot: those of the simulation, contacts begun at more than 0.08 m/s into the wall; contacts within
    50 ms of one on the same surface belong to it. Of a real robot: the impacts that were detected in the poses or
    sensed by the ring.
    """

    all: Sequence[Impact]
    verdicts: Verdicts  # which were foreseen, which deliberate, and how well

    @cached_property
    def speeds(self) -> np.ndarray:
        """Speed of each impact into the obstacle (k,) [m/s]."""
        return np.array([impact.speed_into for impact in self.all])

    @property
    def restitutions(self) -> list[float]:
        """Share of the speed into the obstacle that came back, of each impact that is hard enough to tell it."""
        hard = (each for each in self.all if each.speed_into >= HARD and not each.with_mover)
        return [float(each.velocity_after @ each.normal) / each.speed_into for each in hard]


def impacts_of(log: RunLog, velocity_window: float) -> JudgedImpacts:
    """The impacts of a run. The velocity after a measured one is that which poses show later, and so better.

    `velocity_window` is mocap.velocity_window, over which velocities of measured poses are fitted [s].
    """
    impacts = log.own_impacts if log.poses else []
    if not log.truth:
        impacts = [
            replace(each, velocity_after=_settled(each, impacts, log.poses, velocity_window)) for each in impacts
        ]
    predictions = [Prediction(made, contacts) for made, contacts in sorted(log.plans.items())]
    return JudgedImpacts(impacts, judge_impacts(impacts, predictions))


def _settled(impact: Impact, impacts: Sequence[Impact], poses: list[PoseRow], velocity_window: float) -> np.ndarray:
    """Velocity after a measured impact: of the first pose fitted to later ones alone, or the last before the next."""
    later = min((other.time for other in impacts if other.time > impact.time), default=math.inf)
    settled = min(_first_from(impact.time + SETTLED * velocity_window, poses), _first_from(later, poses) - 1)
    row = poses[max(settled, 0)]
    return np.array([row.vx, row.vy])


def _first_from(stamp: float, track: list[PoseRow]) -> int:
    """Returns the index of the first pose at or after a stamp [s]."""
    return bisect_left(track, stamp, key=lambda row: row.stamp)


def write_impacts(path: Path, impacts: JudgedImpacts, begin: float) -> None:
    """Writes one row per impact; t counts from `begin` [s], as in trajectory.csv."""
    verdicts = impacts.verdicts
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for each, error, *kinds in zip(
            impacts.all, verdicts.rebounds[:, 0], verdicts.foreseen, verdicts.deliberate, strict=True
        ):
            vectors = each.point, each.normal, each.velocity_before, each.velocity_after
            numbers = [each.time - begin, *np.concatenate(vectors), error]
            writer.writerow([*(f"{number:.6f}" for number in numbers), *(str(bool(kind)).lower() for kind in kinds)])


def counted_impacts(number: int) -> str:
    """Number of impacts in words: "1 impact", "2 impacts"."""
    return f"{number} impact{'' if number == 1 else 's'}"
