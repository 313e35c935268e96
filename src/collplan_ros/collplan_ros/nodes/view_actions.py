"""Actions that the page requests, done in the graph: a stop before everything that waits."""

import queue
from collections.abc import Callable
from itertools import count

import numpy as np
from geometry_msgs.msg import PoseStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rclpy.node import Node
from std_srvs.srv import Trigger

from collplan_ros.messages.conversions import goal_to_message, stamp_from_seconds
from collplan_ros.messages.qos import EVENT
from collplan_ros.node_kit.service_calls import ServiceCalls
from collplan_ros.view.commands import CANCEL, CHOOSE, CLEAR_STOP, GOAL, RESUME, STOP, PageCommand
from collplan_ros.view.drawn_graph import DrawnGraph
from collplan_ros.view.server import Reply

STRATEGY = "planner.strategy"
SERVICES = (STOP, CANCEL, RESUME, CLEAR_STOP)
"""Actions that are services of the same name."""
MOST_WAITING = 100
"""Commands that may wait; a stop always may."""


class ViewActions:
    """Takes commands from any thread and does them in the node's own."""

    def __init__(self, node: Node, calls: ServiceCalls, graph: Callable[[], DrawnGraph], frame: str) -> None:
        """Publishes and calls through `node`, to nodes that the present `graph` hears; goals are in `frame`."""
        self._node = node
        self._calls = calls
        self._graph = graph
        self._frame = frame
        self._goals = node.create_publisher(PoseStamped, "goal_pose", EVENT)
        for name in SERVICES:
            calls.keep(Trigger, name)
        self._order = count()
        self._inbox: queue.PriorityQueue[tuple[bool, int, PageCommand, Reply]] = queue.PriorityQueue()

    def take(self, command: PageCommand, reply: Reply) -> None:
        """Queues a command for the node; may be called from any thread."""
        if command.action != STOP and self._inbox.qsize() >= MOST_WAITING:
            reply(False, "too many commands are waiting")
            return
        self._inbox.put((command.action != STOP, next(self._order), command, reply))
        if self._node.executor is not None:
            self._node.executor.create_task(self.do_all)

    def do_all(self) -> None:
        """Executes the queued commands, stops first."""
        while True:
            try:
                *_, command, reply = self._inbox.get_nowait()
            except queue.Empty:
                return
            self._node.get_logger().info(f"page: {_in_words(command)}")
            self._do(command, reply)

    def _do(self, command: PageCommand, reply: Reply) -> None:
        if command.action in SERVICES:

            def answered(response: Trigger.Response | None, trouble: str) -> None:
                reply(bool(response and response.success), trouble if response is None else str(response.message))

            self._calls.now(command.action, Trigger.Request(), answered)
        elif command.action == GOAL:
            self._give_goal(command, reply)
        elif command.action == CHOOSE:
            self._choose(command.strategy, reply)

    def _choose(self, strategy: str, reply: Reply) -> None:
        """Sets the strategy of the planner among the nodes that are heard, and replies with its answer."""
        known, heard = self._graph().parameters, self._graph().heard
        planners = [node for node, values in known.items() if STRATEGY in values and node in heard]
        if not planners:
            reply(False, f"no node with {STRATEGY} was found")
            return

        def done(response: SetParameters.Response | None, trouble: str) -> None:
            if response is None:
                reply(False, trouble)
                return
            result = response.results[0]
            reply(bool(result.successful), str(result.reason) or f"{STRATEGY} is {strategy}")

        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=strategy)
        request = SetParameters.Request(parameters=[Parameter(name=STRATEGY, value=value)])
        self._calls.soon(SetParameters, f"{planners[-1]}/set_parameters", request, done)

    def _give_goal(self, command: PageCommand, reply: Reply) -> None:
        # this node receives goals too
        if self._goals.get_subscription_count() < 2:
            reply(False, f"no node subscribes to {self._goals.topic_name}")
            return
        message = goal_to_message(np.array(command.at), self._frame)
        message.header.stamp = stamp_from_seconds(1e-9 * self._node.get_clock().now().nanoseconds)
        self._goals.publish(message)
        reply(True, f"goal ({command.at[0]:.2f}, {command.at[1]:.2f}) given")


def _in_words(command: PageCommand) -> str:
    if command.action == GOAL:
        return f"goal ({command.at[0]:.3f}, {command.at[1]:.3f})"
    return f"strategy {command.strategy!r}" if command.action == CHOOSE else command.action
