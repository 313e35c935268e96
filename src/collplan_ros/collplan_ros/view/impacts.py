"""Impacts as they happen: whether a plan in force foresaw each, and whether it was deliberate."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from collplan_core.evaluation.impact_matching import KINDS, Prediction, judge_impacts, last_before
from collplan_core.plan import Plan
from collplan_core.sensing.impact_contact import ImpactContact
from collplan_core.state import State
from collplan_ros.view import scene

KEPT = 1.5
"""Time for which plans are kept [s]; an impact is found 0.02 to 0.08 s after it."""
MOST = 200
"""Impacts that are kept."""


class ShownImpacts:
    """The impacts so far, as sent to the page.

    Attributes:
        part: the part `impacts` of a frame, the newest MOST of them.
        counts: the part `counts` of a frame, of all of them.
    """

    def __init__(self) -> None:
        self.part: list[scene.Part] = []
        self.counts = dict.fromkeys(KINDS, 0)
        self._predictions: deque[Prediction] = deque()

    def planned(self, plan: Plan) -> None:
        """Takes a plan."""
        self._predictions.append(Prediction(plan.stamp, plan.contacts))
        while self._predictions[0].made < plan.stamp - KEPT:
            self._predictions.popleft()

    def happened(self, contact: ImpactContact, states: Sequence[State]) -> None:
        """Takes an impact and the states around it, in order; without any its speed is given as 0."""
        before = last_before(contact.time, states).velocity if states else np.zeros(2)
        # into the wall
        speed = max(0.0, -float(before @ contact.normal))
        one = np.array([contact.time]), contact.point[None], np.array([speed])
        self.add(scene.impact(contact, judge_impacts(*one, self._predictions).kind(0), speed))

    def add(self, impact: scene.Part) -> None:
        """Takes an impact as the page shows it."""
        # made anew: what was sent before stays as it was
        self.counts = {**self.counts, impact["kind"]: self.counts[impact["kind"]] + 1}
        self.part = [*self.part, impact][-MOST:]
