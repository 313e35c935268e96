"""Manual commands as controller_node takes them: not too old, and from one sender."""

import math
from collections.abc import Callable

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node

from collplan_core.ages import SenderAge
from collplan_core.parameters import Settings
from collplan_ros.messages.conversions import asks_for_rest, command_type
from collplan_ros.messages.qos import NEWEST
from collplan_ros.messages.reading import twist_of
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.node_kit.inputs import EVENT, Inputs
from collplan_ros.node_kit.publishers import Commanders

TOPIC = "hand/cmd_vel"
Take = Callable[[np.ndarray, float, float, str], None]
"""Takes a velocity (2,) [m/s, body frame], a yaw rate [rad/s], the age [s], and why it must not be followed."""


class TeleopInput:
    """Subscription to hand/cmd_vel.

    Commands that are too old are left out, and the first command of a sender, whose age is unknown. A command to rest
    is never left out, as it moves nothing.
    """

    def __init__(self, node: Node, inputs: Inputs, settings: Settings, take: Take) -> None:
        """Subscribes through `inputs`, and hands each command that is not too old to `take`."""
        self._inputs = inputs
        self._limit = settings.limits.hand_age
        self._hand_on = take
        # steady even where the node follows /clock: how long a message takes is real time
        self._steady = steady_clock()
        self._age = SenderAge(self._limit)
        self._senders = Commanders(node, TOPIC)
        inputs.listen(command_type(settings.controller), TOPIC, self._take, NEWEST, EVENT, kind="hand")

    def why_refused(self) -> str:
        """Returns which nodes send such commands now, where there are several; else ""."""
        self._senders.look(seconds(self._steady))
        return self._senders.why_refused

    def _take(self, message: Twist | TwistStamped) -> None:
        now = seconds(self._steady)
        self._senders.took(self._inputs.number, now)
        age = self._age.measured(self._inputs.sent, now)
        twist = twist_of(message)
        if asks_for_rest(twist):
            age = 0.0
        if age > self._limit:
            if math.isfinite(age):
                self._inputs.refused(TOPIC, f"{age:.2f} s old, limit {self._limit:.2f} s", "hand")
            return
        velocity = np.array([twist.linear.x, twist.linear.y], dtype=float)
        self._hand_on(velocity, float(twist.angular.z), age, self.why_refused())
