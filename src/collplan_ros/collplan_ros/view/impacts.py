"""Impacts as they happen: whether a plan in force foresaw each, and whether it was deliberate."""

from collections import deque

from collplan_core.evaluation.impact_matching import KEPT, KINDS, Prediction, judge_impacts
from collplan_core.impact import Impact
from collplan_core.plan import Plan
from collplan_ros.view import scene

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

    def happened(self, impact: Impact) -> None:
        """Takes an impact."""
        self.add(scene.impact(impact, judge_impacts([impact], self._predictions).kind(0)))

    def add(self, impact: scene.Part) -> None:
        """Takes an impact as the page shows it."""
        # made anew: what was sent before stays as it was
        self.counts = {**self.counts, impact["kind"]: self.counts[impact["kind"]] + 1}
        self.part = [*self.part, impact][-MOST:]
