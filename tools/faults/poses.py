"""A motion capture that lies, and clocks that are set."""

from collections.abc import Callable
from itertools import pairwise

from collplan_ros.messages.states import FREE
from faults.fault import Act, Fault, Measured
from faults.live_graph import LiveGraph, at_full_speed
from faults.stands import WAIT, Measure, commanded_to_stand
from faults.streams import why_stalled

REFUSED = 0.15
"""Longest time from the first refused pose to zero [s]."""
LATE = 0.3
"""Longest time from the first late pose to zero [s]."""
GAP = 0.1
"""Longer than between poses that come in time [s]."""
DRIVES_ON = 1.0
"""Longest time for which the robot is commanded to stand after a clock was set: after longer it would be held [s]."""
WATCHED = 1.2
"""Time watched after each step of a clock [s]."""
HOLD = 0.8
"""For so long a lie lasts, and the robot must go on standing [s]."""


def lie(fault: str) -> Callable[[LiveGraph], float]:
    def act(graph: LiveGraph) -> float:
        begun = graph.now()
        graph.let("simulator_node", simulator__mocap_fault=fault)
        return begun

    return act


def truth_again(graph: LiveGraph) -> None:
    graph.let("simulator_node", simulator__mocap_fault="none")
    graph.pause(0.3)


def first_refused(graph: LiveGraph, begun: float) -> float:
    """When the first refusal of a pose was sent; the fault's own time where none was."""
    return next((row.sent for row in graph.streams.refusals if row.sent > begun), begun)


def first_late(graph: LiveGraph, begun: float) -> float:
    """When the first pose was sent after the gap that a growing delay makes; the fault's own time without."""
    sent = [row.sent for row in graph.streams.poses if row.sent > begun - GAP]
    return next((after for before, after in pairwise(sent) if after > begun and after - before > GAP), begun)


def drives_on(graph: LiveGraph, begun: float) -> Measured:
    """The longer one of the times for which the robot is commanded to stand, after the step and after that back."""
    seconds = max(stood(graph, begun), stood(graph, lie("none")(graph)))
    missed = "" if graph.state == FREE and graph.goal_goes_on else f"{graph.state}, goal {graph.streams.goals[-1].what}"
    streams, now = graph.streams, graph.now()
    stalled = why_stalled("controller_node", (row.sent for row in streams.commands), begun, now)
    # it drives on with the next plan
    stalled = stalled or why_stalled("planner_node", streams.beats, begun, now)
    return Measured(seconds, missed, stalled)


def stood(graph: LiveGraph, begun: float) -> float:
    """For how long in all the robot is commanded to stand within WATCHED [s]."""
    commands = graph.streams.commands
    graph.until(lambda: commands[-1].sent > begun + WATCHED, WATCHED + WAIT)
    rows = [row for row in commands if row.sent > begun]
    return sum(after.sent - row.sent for row, after in pairwise(rows) if not row.moves)


def row(name: str, act: Act, limit: float, measure: Measure) -> Fault:
    return Fault(f"mocap: {name}", "simulator", limit, act, measure, truth_again)


refused, late = commanded_to_stand(HOLD, first_refused), commanded_to_stand(HOLD, first_late)
ON = "longest time commanded to stand, then it drives on"
FAULTS = [
    row("heading flips by 90 degrees", lie("yaw_90"), REFUSED, refused),
    row("heading flips by 180 degrees", lie("yaw_180"), REFUSED, refused),
    row("robot tipped by 30 degrees", lie("tilt"), REFUSED, refused),
    row("robot lifted by 0.2 m", lie("lift"), REFUSED, refused),
    row("poses 0.2 s late, from the first late one on", at_full_speed(lie("late")), LATE, late),
    row(f"clock set ahead by 1 h and back: {ON}", lie("hour_ahead"), DRIVES_ON, drives_on),
    row(f"clock set back by 1 h and ahead: {ON}", lie("hour_back"), DRIVES_ON, drives_on),
]
