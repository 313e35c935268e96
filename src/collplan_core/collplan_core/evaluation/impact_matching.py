"""Matching of a run's impacts with the contacts that its plans foresaw."""

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from collplan_core.plan import Contacts

TIME_TOLERANCE = 0.15
"""Largest difference in time between an impact and the contact that foresaw it [s]."""
DISTANCE_TOLERANCE = 0.08
"""Largest distance between the two [m]."""
NOTICE = 0.15
"""A plan made less than this before an impact only confirms what an earlier one foresaw [s]."""
AT_ONCE = 0.01
"""A plan made less than this before an impact begins at the wall and may already leave from it [s]."""
DELIBERATE_SPEED = 0.2
"""A foreseen impact faster than this into the wall is deliberate [m/s]."""
UNMATCHED = -1
KINDS = DELIBERATE, FORESEEN, OTHER = "deliberate", "foreseen", "other"


@dataclass(frozen=True, eq=False)
class Prediction:
    """One plan's foreseen contacts, and its stamp [s]."""

    made: float
    contacts: Contacts


class Verdicts(NamedTuple):
    """Verdicts of the plans on k impacts.

    Attributes:
        foreseen: (k,) whether a plan in force foresaw each: a plan made at least NOTICE before it has a contact within
            TIME_TOLERANCE and DISTANCE_TOLERANCE, and every plan made since, up to AT_ONCE before it, has one too.
            Within a plan one contact stands for one impact.
        deliberate: (k,) whether each was foreseen, and faster into the wall than a graze: DELIBERATE_SPEED.
    """

    foreseen: np.ndarray
    deliberate: np.ndarray

    def kind(self, k: int) -> str:
        """One of KINDS: that of an impact."""
        return DELIBERATE if self.deliberate[k] else FORESEEN if self.foreseen[k] else OTHER


def judge_impacts(
    times: np.ndarray, points: np.ndarray, speeds_into: np.ndarray, predictions: Sequence[Prediction]
) -> Verdicts:
    """Marks which impacts were foreseen, and which were deliberate.

    Args:
        times: (k,) when they were [s].
        points: (k, 2) where on the obstacles [m].
        speeds_into: (k,) speed into the wall before each [m/s].
        predictions: one of every plan of the run, also of those that foresee nothing, in order of `made`.
    """
    made = np.array([p.made for p in predictions])
    matched = np.array([match_contacts(times, points, p.contacts) != UNMATCHED for p in predictions], dtype=bool)
    matched = matched.reshape(len(predictions), len(times))
    foreseen = np.array([_announced(t, made, matched[:, i]) for i, t in enumerate(times)], dtype=bool)
    return Verdicts(foreseen, foreseen & (speeds_into > DELIBERATE_SPEED))


def last_before(stamp: float, track: Sequence[Any]) -> Any:
    """The last pose before a stamp [s] of a track in order, or the first: an impact is over in the pose of its stamp.

    Its velocity is the one before an impact: none that is fitted later is free of it.
    """
    return track[max(bisect_left(track, stamp, key=lambda pose: pose.stamp) - 1, 0)]


def foreseen_rebounds(
    times: np.ndarray, points: np.ndarray, velocities_after: np.ndarray, predictions: Sequence[Prediction]
) -> np.ndarray:
    """The rebound that the last plan before each impact foresaw, beside the true one.

    Args:
        times: (k,) [s], points: (k, 2) [m], velocities_after: (k, 2) [m/s] of the impacts.

    Returns:
        (k, 3): angle between the two velocities in [0, pi] [rad], speed foreseen, true speed [m/s]; NaN where that plan
        foresaw no such impact.
    """
    result = np.full((len(times), 3), np.nan)
    made = np.array([p.made for p in predictions])
    for i, time in enumerate(times):
        k = int(np.searchsorted(made, time)) - 1
        foreseen = None if k < 0 else _foreseen_rebound(time, points[i], predictions[k].contacts)
        if foreseen is not None:
            came = velocities_after[i]
            turn = math.atan2(foreseen[0] * came[1] - foreseen[1] * came[0], float(foreseen @ came))
            result[i] = abs(turn), np.hypot(*foreseen), np.hypot(*came)
    return result


def _foreseen_rebound(time: float, point: np.ndarray, contacts: Contacts) -> np.ndarray | None:
    """Velocity (2,) [m/s] after an impact at a time [s] and point (2,) [m], by one plan; None where it foresaw none."""
    match = match_contacts(np.array([time]), point[None], contacts)[0]
    return None if match == UNMATCHED else contacts.velocities_after[match]


def _announced(time: float, made: np.ndarray, matched: np.ndarray) -> bool:
    for k in range(int(np.searchsorted(made, time - AT_ONCE)) - 1, -1, -1):
        if not matched[k]:
            return False
        if made[k] <= time - NOTICE:
            return True
    return False


def match_contacts(times: np.ndarray, points: np.ndarray, contacts: Contacts) -> np.ndarray:
    """(k,) index of the contact that stands for each impact, UNMATCHED without one; the nearest pairs first."""
    if len(times) == 0 or len(contacts.times) == 0:
        return np.full(len(times), UNMATCHED)
    late = np.abs(times[:, None] - contacts.times[None, :]) / TIME_TOLERANCE
    far = np.linalg.norm(points[:, None] - contacts.points[None, :], axis=2) / DISTANCE_TOLERANCE
    return _nearest_pairs(np.where((late <= 1.0) & (far <= 1.0), np.hypot(late, far), np.inf))


def _nearest_pairs(distance: np.ndarray) -> np.ndarray:
    result = np.full(distance.shape[0], UNMATCHED)
    distance = distance.copy()
    while np.isfinite(distance).any():
        i, j = np.unravel_index(int(distance.argmin()), distance.shape)
        result[i] = j
        distance[i, :] = np.inf
        distance[:, j] = np.inf
    return result
