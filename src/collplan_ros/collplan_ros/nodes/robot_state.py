"""The topic robot/state: whether the robot may move, and why not."""

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from rclpy.node import Node

from collplan_ros.messages import qos
from collplan_ros.messages.states import FREE, HELD
from collplan_ros.node_kit.clock import steady_clock

AGAIN = 1.0
"""Period at which the present state is repeated [s]: after a restart a latched message can be seconds late."""


class RobotState:
    """Publishes robot/state, latched, at every change and each AGAIN; logs changes too.

    Attributes:
        name: FREE, HELD or STOPPED.
        message: reason why the robot does not move, and how to release it; empty where it is free.
    """

    def __init__(self, node: Node) -> None:
        """Publishes through `node`; `tell` is to be called with the first state."""
        self.name = self.message = ""
        self._knows_planner = False
        self._log = node.get_logger()
        self._source = node.get_fully_qualified_name()
        self._out = node.create_publisher(DiagnosticStatus, "robot/state", qos.LATCHED)
        self._status = DiagnosticStatus()
        node.create_timer(AGAIN, lambda: self._out.publish(self._status), clock=steady_clock())

    def tell(self, name: str, reason: str, remedy: str, knows_planner: bool) -> None:
        """Publishes the present state if it is another one.

        Args:
            name: FREE, HELD or STOPPED.
            reason: reason why the robot does not move; empty where it is free.
            remedy: action that lets it move again.
            knows_planner: whether the planner was received: a goal given from then on is a new one.
        """
        whole = f"held, {reason}" if name == HELD else reason
        message = f"{whole}: {remedy}" if reason else ""
        if (name, message, knows_planner) == (self.name, self.message, self._knows_planner):
            return
        is_news, is_first = (name, message) != (self.name, self.message), not self.name
        self.name, self.message, self._knows_planner = name, message, knows_planner
        level = DiagnosticStatus.OK if name == FREE else DiagnosticStatus.WARN
        values = {"state": name, "reason": reason, "knows_planner": "yes" if knows_planner else "no"}
        pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
        self._status = DiagnosticStatus(level=level, name=self._source, message=message, values=pairs)
        self._out.publish(self._status)
        if not is_news:
            return
        if name == FREE or is_first:
            self._log.info(message or "free: commands are followed")
        else:
            self._log.warning(message)
