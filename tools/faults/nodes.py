"""Nodes that are frozen or killed."""

from faults.fault import Fault
from faults.live_graph import LiveGraph
from faults.stands import commanded_to_stand

HEARTBEAT = 0.30
"""[s]"""
SILENCE = 0.25
"""Longest time from the last pose to zero: limits.pose_age, a control period, and what a message takes [s]."""
SCAN_SILENCE = 0.35
"""The same of scans, whose period counts too [s]."""


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


FAULTS = [
    frozen("planner_node", HEARTBEAT),
    killed("planner_node", HEARTBEAT),
    frozen("mocap_node", SILENCE),
    killed("mocap_node", SILENCE),
    frozen("lidar_node", SCAN_SILENCE),
    killed("lidar_node", SCAN_SILENCE),
]
