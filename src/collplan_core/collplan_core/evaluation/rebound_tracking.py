"""Rebounds as a plan foresaw them and as they were measured, for display; nothing is decided by it."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from collplan_core.evaluation.impact_matching import Prediction, foreseen_rebound
from collplan_core.plan import Plan
from collplan_core.sensing.impact_contact import impact_contact
from collplan_core.state import State

KEPT = 0.3
"""Longest time before an impact was found at which a plan may have foreseen it [s]."""


@dataclass(frozen=True, eq=False)
class MeasuredImpact:
    """One impact, world frame.

    Attributes:
        stamp: time of its detection [s].
        point: (2,) where the ring touched, from the direction of the change of velocity [m].
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
    """Compares each measured impact with the plans made before it."""

    def __init__(self) -> None:
        """Starts without plans and impacts."""
        self._predictions: deque[Prediction] = deque()
        self._impact: MeasuredImpact | None = None

    def planned(self, plan: Plan) -> None:
        """Takes a plan that is in force from now on."""
        self._predictions.append(Prediction(plan.stamp, plan.contacts))
        while self._predictions[0].made < plan.stamp - KEPT:
            self._predictions.popleft()

    def impact(self, stamp: float, change: np.ndarray, state: State, radius: float) -> None:
        """An impact was found at `stamp` [s]: change of velocity (2,) [m/s], newest state, radius of the disc [m]."""
        point = impact_contact(stamp, state.position, change, radius).point
        self._impact = MeasuredImpact(stamp, point, self._foreseen(stamp, point), np.full(2, math.nan))

    def moved(self, state: State, settled: float) -> MeasuredImpact | None:
        """The impact, once: at the first state `settled` [s] after it, when the velocity is the one after alone."""
        impact = self._impact
        if impact is None or state.stamp < impact.stamp + settled:
            return None
        self._impact = None
        return MeasuredImpact(impact.stamp, impact.point, impact.foreseen, state.velocity)

    def forget(self) -> None:
        """Drops plans and impacts, as after a break in the poses: they belong to another place."""
        self._predictions.clear()
        self._impact = None

    def _foreseen(self, stamp: float, point: np.ndarray) -> np.ndarray:
        # it was found late: plans made since then no longer expect it
        lately = (each.contacts for each in reversed(self._predictions) if each.made >= stamp - KEPT)
        foreseen = (foreseen_rebound(stamp, point, contacts) for contacts in lately)
        return next((velocity for velocity in foreseen if velocity is not None), np.full(2, math.nan))
