"""Nodes that are frozen or killed."""

from collplan_ros.bringup.graph import COMMANDER
from faults.bench import BenchError
from faults.fault import Fault, Measured
from faults.live_graph import REST, LiveGraph
from faults.stands import CREEP, commanded_to_stand, no_motion_since

HEARTBEAT = 0.30
"""[s]"""
SILENCE = 0.25
"""Longest time from the last pose to zero: limits.pose_age, a control period, and what a message takes [s]."""
SCAN_SILENCE = 0.35
"""The same of scans, whose period counts too [s]."""
SLOW = 0.2
"""A robot that goes from rest to its speed is on the way there [m/s]."""
LOST = 1.5
"""For so long poses are lost: after over 1 s the robot is held [s]."""
WATCHED = 2.0
"""Time watched after that [s]."""


def frozen(node: str, limit: float, hold: float = 0.6) -> Fault:
    return Fault(
        f"{node} frozen",
        "simulator",
        limit,
        lambda graph: graph.freeze(node),
        commanded_to_stand(hold),
        lambda graph: graph.thaw(node),
    )


def killed(node: str, limit: float, hold: float = 0.6) -> Fault:
    def undo(graph: LiveGraph) -> None:
        graph.restart(node)

    act = lambda graph: graph.kill(node)  # noqa: E731
    return Fault(f"{node} killed", "simulator", limit, act, commanded_to_stand(hold), undo)


def freeze_speeding_up(graph: LiveGraph) -> float:
    """The robot freezes while it gains speed from rest, and its commander later: what it sent last is faster still."""
    graph.cancel_goal()
    graph.until(lambda: not graph.streams.commands[-1].moves and not graph.moves, REST)
    graph.give_goal(graph.farther_end())
    if not graph.until(lambda: graph.streams.truth[-1].speed > SLOW, REST):
        raise BenchError(f"the robot does not drive: {graph.described()}")
    begun = graph.freeze("simulator_node")
    graph.pause(graph.chance.uniform(0.1, 0.18))
    graph.freeze("controller_node")
    return begun


def queued_command(graph: LiveGraph, begun: float) -> Measured:
    """Whether the robot, running again, becomes faster than was commanded before it froze."""
    allowed = next(row.speed for row in reversed(graph.streams.commands) if row.sent <= begun)
    graph.pause(graph.chance.uniform(0.3, 1.5))
    again = graph.thaw("simulator_node")
    graph.pause(0.5)
    fastest = max((row.speed for row in graph.streams.truth if row.sent > again), default=0.0)
    return Measured(missed=f"{fastest:.2f} m/s after {allowed:.2f} m/s" if fastest > allowed + CREEP else "")


def thaw_both(graph: LiveGraph) -> None:
    graph.thaw("simulator_node")
    graph.thaw("controller_node")


def poses_lost(graph: LiveGraph) -> float:
    graph.freeze("mocap_node")
    graph.pause(LOST)
    return graph.thaw("mocap_node")


def still_held(graph: LiveGraph, back: float) -> Measured:
    """It stands though the poses are back, and the controller says that a person has to let it move."""
    graph.pause(WATCHED)
    return Measured(missed=no_motion_since(graph, back) or ("" if graph.value(COMMANDER, "held") else "it is not held"))


FAULTS = [
    frozen("planner_node", HEARTBEAT),
    killed("planner_node", HEARTBEAT),
    frozen("mocap_node", SILENCE),
    killed("mocap_node", SILENCE),
    frozen("lidar_node", SCAN_SILENCE),
    killed("lidar_node", SCAN_SILENCE),
    Fault(
        "simulator_node and its commander frozen, it runs again: nothing queued is followed",
        "simulator",
        None,
        freeze_speeding_up,
        queued_command,
        thaw_both,
        long=200,
    ),
    Fault(f"poses lost for {LOST:g} s and back, then no motion", "simulator", None, poses_lost, still_held),
]
