"""Impacts as they happen: whether a plan in force foresaw each, and whether it was deliberate."""

from collections import deque

import numpy as np

from collplan_core.evaluation.impact_matching import KINDS, Prediction, judge_impacts, last_before
from collplan_core.plan import Plan
from collplan_core.sensing.impact_contact import ImpactContact
from collplan_core.state import State
from collplan_ros.view import scene

KEPT = 1.5
"""Time for which plans and poses are kept [s]; an impact is found 0.02 to 0.08 s after it."""
MOST = 200
"""Impacts that are kept."""


class ShownImpacts:
    """The impacts so far, as the page is sent them.

    Attributes:
        part: the part `impacts` of a frame, the newest MOST of them.
        counts: the part `counts` of a frame, of all of them.
    """

    def __init__(self) -> None:
        self.part: list[scene.Part] = []
        self.counts = dict.fromkeys(KINDS, 0)
        self._predictions: deque[Prediction] = deque()
        self._states: deque[State] = deque()

    def planned(self, plan: Plan) -> None:
        """Takes a plan."""
        self._predictions.append(Prediction(plan.stamp, plan.contacts))
        while self._predictions[0].made < plan.stamp - KEPT:
            self._predictions.popleft()

    def moved(self, state: State) -> None:
        """Takes the next state."""
        self._states.append(state)
        while self._states[0].stamp < state.stamp - KEPT:
            self._states.popleft()

    def happened(self, contact: ImpactContact) -> None:
        """Takes an impact."""
        speed = self._speed_into(contact)
        one = np.array([contact.time]), contact.point[None], np.array([speed])
        kind = judge_impacts(*one, self._predictions).kind(0)
        # made anew: what was sent before stays as it was
        self.counts = {**self.counts, kind: self.counts[kind] + 1}
        self.part = [*self.part, scene.impact(contact, kind, speed)][-MOST:]

    def _speed_into(self, contact: ImpactContact) -> float:
        """Speed into the wall before an impact [m/s]; 0 without a pose."""
        before = last_before(contact.time, self._states) if self._states else None
        return 0.0 if before is None else max(0.0, -float(before.velocity @ contact.normal))
