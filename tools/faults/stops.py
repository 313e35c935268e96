"""What a person or the robot itself does to stop it, and that it goes on standing."""

from collections.abc import Callable
from dataclasses import replace
from itertools import count

from geometry_msgs.msg import Twist
from rclpy.node import Node

from collplan_ros.messages.qos import NEWEST
from collplan_ros.messages.states import HELD, STOPPED
from faults.fault import Fault, Measured
from faults.live_graph import LiveGraph, at_full_speed
from faults.stands import no_motion_since, robot_stops, wheels_stop

CALL = 0.2
"""Longest time from the call of estop, or a bit in the telemetry, to zero at the robot [s]."""
COMMANDER = 0.5
"""Longest time from a second publisher to zero at the robot [s]."""
NO_MOTION = 2.0
"""Time watched after clear_estop [s]."""
PUBLISHED = 500
"""Cases of the long run where a 99th percentile is to be told."""
OCCLUSION = 0.4
"""For so long poses are lost meanwhile: the controller's own zeros must not let the robot move [s]."""
ROBOTS = {"simulator": robot_stops, "serial": wheels_stop}
_numbers = count()


def estop(graph: LiveGraph) -> float:
    begun = graph.now()
    graph.trigger("estop")
    return begun


def then_cleared(stops: Callable[[LiveGraph, float], Measured]) -> Callable[[LiveGraph, float], Measured]:
    def measure(graph: LiveGraph, begun: float) -> Measured:
        """Nothing moves for NO_MOTION after clear_estop, though the controller loses its poses for a moment."""
        measured = stops(graph, begun)
        clear(graph)
        cleared = graph.now()
        graph.pause(0.5)
        graph.freeze("mocap_node")
        graph.pause(OCCLUSION)
        graph.thaw("mocap_node")
        graph.until(lambda: graph.now() > cleared + NO_MOTION, NO_MOTION)
        wrong = no_motion_since(graph, cleared) or ("" if graph.state == HELD else f"it is {graph.state}")
        return replace(measured, missed=measured.missed or wrong)

    return measure


class SecondPublisher:
    """A second publisher of commands, of a node of its own."""

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self._node: Node | None = None

    def begin(self, graph: LiveGraph) -> float:
        self._node = node = Node(f"second_{next(_numbers)}", context=graph.listener.node.context)
        begun = graph.now()
        self._publisher = node.create_publisher(Twist, self._topic, NEWEST)
        message = Twist()
        message.linear.y = 0.3
        graph.repeat(0.05, lambda: self._publisher.publish(message))
        return begun

    def named(self, stops: Callable[..., Measured]) -> Callable[[LiveGraph, float], Measured]:
        def measure(graph: LiveGraph, begun: float) -> Measured:
            measured = stops(HELD)(graph, begun)
            said = graph.streams.states[-1].why
            if measured.stalled or measured.missed or self._node is None or self._node.get_name() in said:
                return measured
            return replace(measured, missed=f"not named in {said!r}")

        return measure

    def end(self, graph: LiveGraph) -> None:
        graph.repeat(0.05, None)
        if self._node is not None:
            self._node.destroy_node()
        graph.pause(0.3)


def clear(graph: LiveGraph) -> None:
    graph.trigger("clear_estop")


def both(robot: str) -> list[Fault]:
    stops, second = ROBOTS[robot], SecondPublisher("cmd_vel")
    return [
        Fault(
            f"estop; then clear_estop, {NO_MOTION:g} s and poses lost for a moment: no motion",
            robot,
            CALL,
            at_full_speed(estop),
            then_cleared(stops(STOPPED)),
            clear,
            long=PUBLISHED,
        ),
        Fault("second publisher on cmd_vel", robot, COMMANDER, second.begin, second.named(stops), second.end, long=50),
    ]


FAULTS = [fault for robot in ROBOTS for fault in both(robot)]
