"""Markers of the time-to-goal strategies alone: rollouts, remembered boundaries, the solid inferred behind them."""

from collections.abc import Iterable, Sequence

import numpy as np
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from collplan_core.parameters import Settings
from collplan_core.plan import Plan
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries
from collplan_ros.markers.shapes import LINE_WIDTH, color, lines_of_one_color
from collplan_ros.messages.planner_clouds import inferred_lines

ROLLOUT = color(0.2, 0.5, 0.9, 0.5)
REMEMBERED = color(0.25, 0.25, 0.3)
INFERRED = color(0.25, 0.25, 0.3, 0.25)


def rollout_markers(
    head: Header, plan: Plan, remembered: RememberedBoundaries | None, settings: Settings
) -> Iterable[Marker]:
    """Markers of whole rollouts, remembered and inferred boundaries; empty ones, which clear the old, without them."""
    yield lines_of_one_color(head, "rollouts", _strips_as_lines(plan.candidates.paths), ROLLOUT, LINE_WIDTH / 4)
    yield from _boundaries(head, remembered, settings)


def _strips_as_lines(strips: Sequence[np.ndarray]) -> np.ndarray:
    """(2n, 2) ends of all line segments of the strips, each a polyline (k, 2)."""
    return np.concatenate([np.zeros((0, 2)), *(np.repeat(strip, 2, axis=0)[1:-1] for strip in strips)])


def _boundaries(head: Header, remembered: RememberedBoundaries | None, settings: Settings) -> Iterable[Marker]:
    pieces = np.zeros((0, 4)) if remembered is None else remembered.pieces
    yield lines_of_one_color(head, "remembered", pieces.reshape(-1, 2), REMEMBERED)
    solid = np.zeros((0, 2)) if remembered is None else inferred_lines(remembered, settings)
    # each line as wide as its piece is long
    yield lines_of_one_color(head, "inferred", solid, INFERRED, settings.remembered.spacing)
