"""Gives goals to the planner, and cancels them."""

from collections.abc import Callable

import numpy as np
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from std_srvs.srv import Trigger

from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT

PERIOD = 1.0
"""Period at which a goal without answer is published again [s]."""


class Goals:
    """Publisher of goals to the planner, which answers by the status of the goal."""

    def __init__(self, node: Node, frame: str, now: Callable[[], float]) -> None:
        """Publishes through `node` goals in `frame`; `now` is the time for patience [s]."""
        self._now = now
        self._frame = frame
        self._due = 0.0
        self._publisher = node.create_publisher(PoseStamped, "goal_pose", EVENT)
        self._cancel = node.create_client(Trigger, "cancel")

    @property
    def are_heard(self) -> bool:
        """True where a node subscribes to goals."""
        return bool(self._publisher.get_subscription_count() > 0)

    def give(self, goal: np.ndarray, stamp: float) -> None:
        """Publishes a goal (2,) [m] with a stamp [s]."""
        self._publisher.publish(goal_to_message(goal, self._frame, stamp))
        self._due = self._now() + PERIOD

    def repeat(self, goal: np.ndarray, stamp: float) -> None:
        """Publishes it again, once PERIOD is over."""
        if self._now() >= self._due:
            self.give(goal, stamp)

    def cancel(self) -> None:
        """Asks for the end of the goal."""
        if self._cancel.service_is_ready():
            self._cancel.call_async(Trigger.Request())
