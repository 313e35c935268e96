"""Nodes that are frozen or killed."""

from itertools import accumulate
from operator import methodcaller

from collplan_ros.bringup.options import COMMANDER
from faults.fault import Fault, Measured
from faults.live_graph import LiveGraph, at_full_speed
from faults.stands import CREEP, WAIT, commanded_to_stand, no_motion_since
from faults.streams import why_stalled

HEARTBEAT = 0.30
"""[s]"""
SILENCE = 0.25
"""Longest time from the last pose to zero: limits.pose_age, a control period, and what a message takes [s]."""
SCAN_SILENCE = 0.35
"""The same of scans, whose period counts too [s]."""
ON = 0.2
"""Longest time for which a robot that runs again goes on as before: what is left of the command, and the lag [s]."""
SLOWS = 0.6
"""Time watched for that [s]."""
LOST = 1.5
"""For so long poses are lost: after over 1 s the robot is held [s]."""
PLANNED = 0.4
"""By then after a goal was given its first plan is followed [s]."""
WATCHED = 1.5
"""Time watched after that [s]."""


def frozen_and_killed(node: str, limit: float) -> list[Fault]:
    return [
        Fault(
            f"{node} {done}",
            "simulator",
            limit,
            at_full_speed(methodcaller(act, node)),
            commanded_to_stand(0.6),
            methodcaller(undo, node),
        )
        for done, act, undo in (("frozen", "freeze", "thaw"), ("killed", "kill", "restart"))
    ]


def freeze_with_a_queue(graph: LiveGraph) -> float:
    """The commander pauses, the robot freezes, the commander sends what the robot does not take, and freezes too."""
    graph.freeze(COMMANDER)
    graph.pause(0.13)
    begun = graph.freeze("simulator_node")
    graph.thaw(COMMANDER)
    graph.pause(0.08)
    graph.freeze(COMMANDER)
    return begun


def queued_command(graph: LiveGraph, begun: float) -> Measured:
    """How long the robot, running again, does not slow: what is in the queue would give it another command_age."""
    graph.pause(graph.chance.uniform(0.3, 0.9))
    queued = graph.streams.commands[-1]
    again = graph.thaw("simulator_node")
    # what was lost by the freeze comes once more, late
    graph.until(lambda: graph.streams.truth[-1].sent > again + SLOWS, SLOWS + WAIT)
    rows = [row for row in graph.streams.truth if row.sent > again]
    fastest = accumulate((row.speed for row in rows), max)
    slows = next((row.sent for row, top in zip(rows, fastest, strict=True) if row.speed < top - CREEP), None)
    stalled = why_stalled("simulator_node", (row.sent for row in rows), again, slows or graph.now())
    unbegun = "" if queued.moves and queued.sent > begun else "nothing was queued"
    return Measured(None if slows is None else slows - rows[0].sent, "", stalled, unbegun)


def thaw_both(graph: LiveGraph) -> None:
    graph.thaw("simulator_node")
    graph.thaw("controller_node")


def poses_lost(graph: LiveGraph) -> float:
    graph.pause(PLANNED)
    graph.freeze("mocap_node")
    graph.pause(LOST)
    return graph.thaw("mocap_node")


def still_held(graph: LiveGraph, back: float) -> Measured:
    """It stands though the poses are back, and the controller says that a person has to let it move."""
    graph.pause(WATCHED)
    streams = graph.streams
    # a robot whose time stood still comes to rest later
    rolled = streams.motion_at(back).speed > CREEP
    stalled = why_stalled("simulator_node", (row.sent for row in streams.truth), back - LOST, back) if rolled else ""
    wrong = "" if graph.value(COMMANDER, "held") else "it is not held"
    return Measured(missed=no_motion_since(graph, back) or wrong, stalled=stalled)


FAULTS = [
    *frozen_and_killed("planner_node", HEARTBEAT),
    *frozen_and_killed("mocap_node", SILENCE),
    *frozen_and_killed("lidar_node", SCAN_SILENCE),
    Fault(
        "simulator_node and its commander frozen, it runs again: time until it slows",
        "simulator",
        ON,
        freeze_with_a_queue,
        queued_command,
        thaw_both,
        long=200,
    ),
    Fault(f"poses lost for {LOST:g} s and back, then no motion", "simulator", None, poses_lost, still_held),
]
