"""Goals that are none, and the fence."""

from dataclasses import replace
from itertools import takewhile

import numpy as np
from action_msgs.msg import GoalStatus

from faults.bench import BenchError
from faults.fault import Fault, Measured
from faults.live_graph import FENCE_GAP, LiveGraph
from faults.stands import WAIT, commanded_to_stand

ANSWER = 0.25
"""Longest time from a goal that is refused to zero [s]."""
FENCE = 0.2
"""Longest time from the first pose outside to zero [s]."""
BEYOND = np.array([-2.2, 0.0])
"""A goal behind the gap in the fence: the way to it from the start leads through it."""
DRIVE = 5.0
"""[s]"""


def far_away(graph: LiveGraph) -> float:
    begun = graph.now()
    graph.give_goal(np.array([1e9, 0.3]))
    return begun


def refused(graph: LiveGraph, begun: float) -> Measured:
    measured = commanded_to_stand(0.5)(graph, begun)
    if graph.streams.goals[-1].what != GoalStatus.STATUS_ABORTED:
        return replace(measured, missed="the goal is not refused")
    return measured


def outside(graph: LiveGraph) -> float:
    """Drives from the start into the gap; when the first pose outside was sent."""
    carried_back(graph)
    begun = graph.now()
    graph.give_goal(BEYOND)
    if not graph.until(lambda: first_outside(graph, begun), DRIVE):
        raise BenchError(f"the robot does not leave the fence: {graph.described()}")
    return first_outside(graph, begun) or begun


def first_outside(graph: LiveGraph, begun: float) -> float | None:
    (x0, x1), y0 = FENCE_GAP
    # asked with every message: to read all that is kept would take so long that poses are lost meanwhile
    rows = takewhile(lambda row: row.sent > begun, reversed(graph.streams.poses))
    return min((row.sent for row in rows if x0 < row.x < x1 and row.y > y0), default=None)


def left(graph: LiveGraph, begun: float) -> Measured:
    return commanded_to_stand(0.5)(graph, begun)


def carried_back(graph: LiveGraph) -> None:
    graph.trigger("reset")
    graph.until(lambda: graph.streams.poses and abs(graph.streams.poses[-1].x) < 0.2, WAIT)
    graph.pause(0.3)


FAULTS = [
    Fault("goal 1e9 m away", "simulator", ANSWER, far_away, refused),
    Fault("fence left", "simulator", FENCE, outside, left, carried_back),
]
