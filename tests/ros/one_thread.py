"""Every node in the test's own thread: none runs while another works, and only the simulation's clock is common."""

from itertools import count

from collplan_ros.node_kit.stall import StallGuard
from collplan_ros.nodes.heartbeat import HeartbeatWatch
from omnipuck_sim.node import pacing
from omnipuck_sim.node.simulator_node import SimulatorNode

ONE_POSE = 0.01
"""Simulated time between two poses [s]."""
ROUNDS = 4
"""In so many rounds of the executor, each of which takes one message a topic, at most one pose is published."""


def wait_for_each_other(monkeypatch) -> None:
    """Has a stall stop the simulation too, and none of the nodes take for a fault that they do not run for a while."""
    monkeypatch.setattr(pacing, "LONGEST_CATCH_UP", ONE_POSE)
    monkeypatch.setattr(StallGuard, "tick", lambda self, now: False)
    monkeypatch.setattr(HeartbeatWatch, "why_silent", lambda self: "")


def let_others_take(simulator: SimulatorNode) -> None:
    """Has the simulation wait until what it has published is taken, so that no node falls behind."""
    pace, calls = simulator._room._pacing, count()
    due = pace.due
    pace.due = lambda now: 0 if next(calls) % ROUNDS else due(now)
