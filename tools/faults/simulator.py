"""The whole graph with the simulated robot: an emergency stop, nodes frozen or killed, a motion capture that lies."""

from itertools import pairwise
from operator import methodcaller

from collplan_ros.messages.states import STOPPED
from faults.live_graph import LiveGraph, at_full_speed
from faults.runner import Act, Fault, Measure
from faults.stands import commanded_to_stand, estop_fault, robot_stops

LIMITS = {"planner_node": 0.30, "mocap_node": 0.25, "lidar_node": 0.35}
"""Longest time from a node's last word to zero: an age in limits, a control period, and what a message takes [s]."""
HOW = ("frozen", "freeze", "thaw"), ("killed", "kill", "restart")
REFUSED, LATE = 0.15, 0.3
"""Longest time from the first pose that is refused, or late, to zero [s]."""
GAP = 0.1
"""Longer than between poses that come in time [s]."""
HOLD = 0.8
"""For so long a lie lasts, and the robot must go on standing [s]."""


def frozen_or_killed(node: str, done: str, act: str, undo: str) -> Fault:
    done_to, undone = at_full_speed(methodcaller(act, node)), methodcaller(undo, node)
    return Fault(f"{node} {done}", "simulator", LIMITS[node], done_to, commanded_to_stand(0.6), undone)


def lie(fault: str) -> Act:
    return lambda graph: graph.let("simulator_node", simulator__mocap_fault=fault)


def truth_again(graph: LiveGraph) -> None:
    lie("none")(graph)
    graph.pause(0.3)


def first_refused(graph: LiveGraph, begun: float) -> float:
    """When the first refusal of a pose was sent; the fault's own time where none was."""
    return next((row.sent for row in graph.streams.refusals if row.sent > begun), begun)


def first_late(graph: LiveGraph, begun: float) -> float:
    """When the first pose was sent after the gap that a growing delay makes; the fault's own time without."""
    sent = [row.sent for row in graph.streams.poses if row.sent > begun - GAP]
    return next((after for before, after in pairwise(sent) if after > begun and after - before > GAP), begun)


def mocap(name: str, act: Act, limit: float, measure: Measure) -> Fault:
    return Fault(f"mocap: {name}", "simulator", limit, act, measure, truth_again)


refused, late = commanded_to_stand(HOLD, first_refused), commanded_to_stand(HOLD, first_late)
FAULTS = [
    estop_fault("simulator", robot_stops(STOPPED)),
    *(frozen_or_killed(node, *how) for node in LIMITS for how in HOW),
    mocap("heading flips by 90 degrees", lie("yaw_90"), REFUSED, refused),
    mocap("heading flips by 180 degrees", lie("yaw_180"), REFUSED, refused),
    mocap("robot tipped by 30 degrees", lie("tilt"), REFUSED, refused),
    mocap("robot lifted by 0.2 m", lie("lift"), REFUSED, refused),
    mocap("poses 0.2 s late, from the first late one on", at_full_speed(lie("late")), LATE, late),
]
