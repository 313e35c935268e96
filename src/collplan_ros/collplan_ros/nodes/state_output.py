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
        self._goal_active = False

    def publish(self, activity: Activity, maneuver: str, plan_stamp: float | None, goal_active: bool) -> bool:
        """Publishes what is done now, if that is news; returns whether it is.

        Args:
            activity: what the controller is doing.
            maneuver: that of its command.
            plan_stamp: stamp of the plan in force [s]; None without one.
            goal_active: whether the robot is to go to a goal; standing still is then a warning.
        """
        if not activity.differs(self._said) and goal_active == self._goal_active:
            return False
        self._said, self._goal_active = activity, goal_active
        self._out.publish(activity_to_message(activity, maneuver, plan_stamp, goal_active, self._source))
        return True
