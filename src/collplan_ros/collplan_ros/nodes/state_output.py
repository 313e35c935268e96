"""What controller_node publishes about what it is doing."""

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from collplan_core.control.activity import Activity
from collplan_ros.messages import qos
from collplan_ros.messages.controller_state import activity_to_message


class StateOutput:
    """Publishes controller/state at every change; figures in a reason, such as an age, are no change."""

    def __init__(self, node: Node) -> None:
        """Publishes through `node`."""
        self._source = node.get_fully_qualified_name()
        self._out = node.create_publisher(DiagnosticStatus, "controller/state", qos.LATCHED)
        self._said: Activity | None = None
        self._is_to_move = False

    def publish(self, activity: Activity, maneuver: str, plan_stamp: float | None, is_to_move: bool) -> bool:
        """Publishes what is done now, if that is news; returns whether it is.

        Args:
            activity: what the controller is doing.
            maneuver: that of its command.
            plan_stamp: stamp of the plan in force [s]; None without one.
            is_to_move: whether a goal is active, or a hand has trouble in driving it; standing still is then a warning.
        """
        if not activity.differs(self._said) and is_to_move == self._is_to_move:
            return False
        self._said, self._is_to_move = activity, is_to_move
        self._out.publish(activity_to_message(activity, maneuver, plan_stamp, is_to_move, self._source))
        return True
