"""Waits until a started graph is ready, and reports what it lacks where it does not become ready."""

import math
import time
from collections import Counter
from collections.abc import Callable

from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

from collplan_ros.bringup import complaints
from collplan_ros.bringup.complaints import seen_more_than
from collplan_ros.bringup.failures import GraphError
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.listener import NAME
from collplan_ros.bringup.progress import in_words
from collplan_ros.messages.status_values import values_of
from collplan_ros.node_kit.diagnostics import ERROR

READY_PATIENCE = 300.0
"""Longest wait for the nodes to report; they may have to compile first [s]."""
NOTICE_TIME = 5.0
"""Time after which the nodes still waited for are printed [s]."""
LINK_PATIENCE = 3.0
"""Longest wait for the robot's link, once every node has reported [s]."""


def wait_until_poses_come(graph: Graph) -> None:
    """Waits until every node has reported and poses come.

    Raises:
        NodeDied, GraphError, Interrupted, RecordError: as methods of the graph.
    """
    robot, says = graph.preparation.robot.nodes[0], graph.complaints
    graph.wait(_all_reported(graph), READY_PATIENCE, lambda: says.unready(READY_PATIENCE))
    graph.let_time_run()
    twice = seen_more_than(graph.listener.node, Counter([NAME, *graph.preparation.programs]))
    if twice:
        raise GraphError(says.not_alone(f"another {in_words(twice)}"))
    status = graph.recorder.status
    graph.wait(lambda: status(robot).level != ERROR, LINK_PATIENCE, lambda: f"{robot}: {status(robot).message}")
    if values_of(status(robot)).get("impact_sensing") == "yes":
        # else each impact would be published twice
        off = Parameter("mocap.detect_impacts", value=False).to_parameter_msg()
        service = f"{graph.preparation.full_name('mocap_node')}/set_parameters"
        graph.call(SetParameters, service, SetParameters.Request(parameters=[off]))
    graph.wait(lambda: graph.recorder.newest is not None, complaints.INPUT_PATIENCE, says.no_pose)


def wait_until_ready(graph: Graph) -> None:
    """Waits until every node has reported, poses and scans come, and the planner listens for a goal.

    Raises:
        NodeDied, GraphError, Interrupted, RecordError: as methods of the graph.
    """
    wait_until_poses_come(graph)
    recorder, says = graph.recorder, graph.complaints
    # a goal is new to the robot, and lets it move, only after it has received something from the planner
    for condition, complaint in (
        (lambda: recorder.scan_came, says.no_scan),
        (lambda: graph.goals.are_heard, says.no_planner),
        (lambda: recorder.robot.get("knows_planner") == "yes", lambda: says.missing("robot/state", "reliable")),
    ):
        graph.wait(condition, complaints.INPUT_PATIENCE, complaint)
    graph.is_ready = True
    graph.step()


def refuse_kept_stop(graph: Graph) -> None:
    """Waits, where the robot has kept an emergency stop, until somebody clears it, however long that takes.

    The robot does not drive off then: the run ends, and has to be started again.

    Raises:
        GraphError: the emergency stop has been cleared.
    """
    why = graph.recorder.emergency_stop
    if not why:
        return
    clear = graph.complaints.name("clear_estop")
    graph.progress.say(f"{why}: call {clear}, or press Clear emergency stop on the page; Ctrl-C ends")
    graph.wait(lambda: not graph.recorder.emergency_stop, math.inf, str)
    raise GraphError("the emergency stop is cleared: start again to drive")


def _all_reported(graph: Graph) -> Callable[[], bool]:
    notice = time.monotonic() + NOTICE_TIME

    def condition() -> bool:
        nonlocal notice
        silent = graph.complaints.silent_nodes
        if silent and time.monotonic() > notice:
            graph.progress.say(f"waiting for {in_words(silent)} (slow on a busy machine, or before the first compile)")
            notice = math.inf
        return not silent

    return condition
