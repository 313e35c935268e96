"""Matching of a run's impacts with the contacts that its plans foresaw."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

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


@dataclass(frozen=True, eq=False)
class Prediction:
    """One plan's foreseen contacts, and its stamp [s]."""

    made: float
    contacts: Contacts


def foreseen_impacts(times: np.ndarray, points: np.ndarray, predictions: Sequence[Prediction]) -> np.ndarray:
    """(k,) whether each impact, at times (k,) and points (k, 2), was foreseen.

    An impact is foreseen when a plan made at least NOTICE before it has a contact within TIME_TOLERANCE and
    DISTANCE_TOLERANCE, and every plan made since, up to AT_ONCE before the impact, has one too. Within a plan one
    contact stands for one impact. `predictions` holds every plan of the run, also those that foresee nothing, in order
    of `made`.
    """
    made = np.array([p.made for p in predictions])
    matched = np.array([match_contacts(times, points, p.contacts) != UNMATCHED for p in predictions], dtype=bool)
    matched = matched.reshape(len(predictions), len(times))
    return np.array([_announced(t, made, matched[:, i]) for i, t in enumerate(times)], dtype=bool)


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
        if k < 0:
            continue
        contacts = predictions[k].contacts
        match = match_contacts(times[i : i + 1], points[i : i + 1], contacts)[0]
        if match != UNMATCHED:
            foreseen, came = contacts.velocities_after[match], velocities_after[i]
            turn = math.atan2(foreseen[0] * came[1] - foreseen[1] * came[0], float(foreseen @ came))
            result[i] = abs(turn), np.hypot(*foreseen), np.hypot(*came)
    return result


def deliberate_impacts(foreseen: np.ndarray, speeds_into: np.ndarray) -> np.ndarray:
    """(k,) whether each impact was deliberate: a plan foresaw it, and it was faster into the wall than a graze.

    Args:
        foreseen: (k,) whether a plan in force foresaw it.
        speeds_into: (k,) speed into the wall before it [m/s]; a graze has at most DELIBERATE_SPEED.
    """
    return foreseen & (speeds_into > DELIBERATE_SPEED)


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
