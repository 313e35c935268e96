"""Hits as a plan foresaw them and as they came, for whoever watches; nothing is decided by it."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from collplan_core.evaluation.impact_matching import UNMATCHED, Prediction, match_contacts
from collplan_core.plan import Plan
from collplan_core.state import State

KEPT = 0.3
"""Plans made so long before a hit was found are asked whether they foresaw it [s]."""


@dataclass(frozen=True, eq=False)
class MeasuredImpact:
    """One hit, world frame.

    Attributes:
        stamp: when it was found [s].
        point: (2,) where the ring touched, as the change of velocity tells [m].
        foreseen: (2,) velocity after it in the last plan that expected it [m/s]; NaN where none did.
        measured: (2,) velocity that the poses show after it [m/s].
    """

    stamp: float
    point: np.ndarray
    foreseen: np.ndarray
    measured: np.ndarray

    @property
    def direction_error(self) -> float:
        """Angle between the two velocities in [0, pi] [rad]; NaN where it was not foreseen."""
        (ax, ay), (bx, by) = self.foreseen.tolist(), self.measured.tolist()
        return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))


class ReboundTracker:
    """Compares each hit with the plans of before."""

    def __init__(self) -> None:
        """No hit yet."""
        self._predictions: deque[Prediction] = deque()
        self._hit: MeasuredImpact | None = None

    def planned(self, plan: Plan) -> None:
        """One more plan is in force."""
        self._predictions.append(Prediction(plan.stamp, plan.contacts))
        while self._predictions[0].made < plan.stamp - KEPT:
            self._predictions.popleft()

    def hit(self, stamp: float, change: np.ndarray, state: State, radius: float) -> None:
        """A hit was found at `stamp` [s] that changed the velocity by (2,) [m/s]; the disc's radius is in [m]."""
        # the ring touches where the change comes from, but for what the boundary brakes along itself
        point = state.position - radius * change / max(math.hypot(*change), 1e-9)
        self._hit = MeasuredImpact(stamp, point, self._foreseen(stamp, point), np.full(2, math.nan))

    def moved(self, state: State, settled: float) -> MeasuredImpact | None:
        """The hit, once: from the first pose so long [s] after it, when its velocity no longer holds that of before."""
        hit = self._hit
        if hit is None or state.stamp < hit.stamp + settled:
            return None
        self._hit = None
        return MeasuredImpact(hit.stamp, hit.point, hit.foreseen, state.velocity)

    def forget(self) -> None:
        """The poses broke: what was planned and hit before is of another place."""
        self._predictions.clear()
        self._hit = None

    def _foreseen(self, stamp: float, point: np.ndarray) -> np.ndarray:
        for prediction in reversed(self._predictions):
            match = match_contacts(np.array([stamp]), point[None], prediction.contacts)[0]
            if match != UNMATCHED and prediction.made >= stamp - KEPT:
                return prediction.contacts.velocities_after[match]
        return np.full(2, math.nan)
