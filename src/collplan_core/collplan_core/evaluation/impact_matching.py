"""Matching of a run's impacts with the contacts that its plans foresaw."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collplan_core.impact import Impact
from collplan_core.plan import Contacts

TIME_TOLERANCE = 0.15
"""Largest difference in time between an impact and the contact that foresaw it [s]."""
DISTANCE_TOLERANCE = 0.08
"""Largest distance between the two [m]."""
NOTICE = 0.15
"""A plan made less than this before an impact only confirms what an earlier one foresaw [s]."""
AT_ONCE = 0.01
"""A plan made less than this before an impact begins at the wall and may already leave from it [s]."""
KEPT = 1.5
"""Time for which plans are kept to judge impacts as they happen [s]: these are found 0.02 to 0.08 s later."""
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
    """Verdicts of the plans on k impacts."""

    foreseen: np.ndarray
    """(k,) whether a plan in force foresaw each: a plan made at least NOTICE before it has a contact within
    TIME_TOLERANCE and DISTANCE_TOLERANCE, and every plan made since, up to AT_ONCE before it, has one too. Within a
    plan one contact stands for one impact."""
    deliberate: np.ndarray  # (k,) whether each was foreseen, and faster into the wall than a graze: DELIBERATE_SPEED
    rebounds: np.ndarray
    """(k, 3) angle in [0, pi] between the velocity after each and the one that the last plan before it foresaw [rad],
    the speed foreseen and the one after it [m/s]; NaN where that plan foresaw no such impact."""

    def kind(self, k: int) -> str:
        """One of KINDS: that of an impact."""
        return DELIBERATE if self.deliberate[k] else FORESEEN if self.foreseen[k] else OTHER


def judge_impacts(impacts: Sequence[Impact], predictions: Sequence[Prediction]) -> Verdicts:
    """Judges which impacts were foreseen, which were deliberate, and how well their rebounds were foreseen.

    Predictions: one of every plan of the run, also of those that foresee nothing, in order of `made`. Those made more
    than KEPT before an impact make no difference to it.
    """
    made = np.array([p.made for p in predictions])
    matches = np.array([match_contacts(impacts, p.contacts) for p in predictions], dtype=int)
    matches = matches.reshape(len(predictions), len(impacts))
    foreseen, rebounds = np.zeros(len(impacts), dtype=bool), np.full((len(impacts), 3), np.nan)
    for i, impact in enumerate(impacts):
        foreseen[i] = _announced(impact.time, made, matches[:, i] != UNMATCHED)
        last = int(np.searchsorted(made, impact.time)) - 1
        if last >= 0 and matches[last, i] != UNMATCHED:
            rebounds[i] = _beside(predictions[last].contacts.velocities_after[matches[last, i]], impact.velocity_after)
    speeds = np.array([impact.speed_into for impact in impacts])
    return Verdicts(foreseen, foreseen & (speeds > DELIBERATE_SPEED), rebounds)


def _beside(foreseen: np.ndarray, came: np.ndarray) -> tuple[float, float, float]:
    """Angle between two velocities (2,) in [0, pi] [rad], and their speeds [m/s]."""
    turn = math.atan2(foreseen[0] * came[1] - foreseen[1] * came[0], float(foreseen @ came))
    return abs(turn), math.hypot(*foreseen), math.hypot(*came)


def _announced(time: float, made: np.ndarray, matched: np.ndarray) -> bool:
    for k in range(int(np.searchsorted(made, time - AT_ONCE)) - 1, -1, -1):
        if not matched[k]:
            return False
        if made[k] <= time - NOTICE:
            return True
    return False


def match_contacts(impacts: Sequence[Impact], contacts: Contacts) -> np.ndarray:
    """(k,) index of the contact that stands for each impact, UNMATCHED without one; the nearest pairs first."""
    if len(impacts) == 0 or len(contacts.times) == 0:
        return np.full(len(impacts), UNMATCHED)
    times = np.array([impact.time for impact in impacts])
    points = np.array([impact.point for impact in impacts])
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
