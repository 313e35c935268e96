"""Hits that the ring has sensed, as the topic `impact`: in the map frame and the poses' time."""

import math

import numpy as np
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock
from rclpy.node import Node

from collplan_core.parameters import Settings
from collplan_core.sensing.pose_history import PoseHistory
from collplan_ros.messages.conversions import MessageError, impact_to_message, state_from_odometry
from collplan_ros.messages.qos import EVENT, POSE_SUBSCRIBED
from collplan_ros.node_kit.clock import PosesClock, seconds
from omnipuck_driver.messages import NEVER, Telemetry

COUNTS = 1 << 16


class SensedImpacts:
    """Listens to `mocap/odom`, for the heading that a hit in the body frame needs, and publishes `impact`.

    Attributes:
        published: hits told.
        missed: hits of which no pose, or no telemetry, told enough.
    """

    def __init__(self, node: Node, settings: Settings, clock: Clock) -> None:
        """Subscribes in `node`."""
        self.published = 0
        self.missed = 0
        self._frames = settings.frames
        self._history = PoseHistory(settings.limits.pose_history)
        self._clock = PosesClock()
        self._counted: tuple[int, int] | None = None
        self._local = clock
        self._publisher = node.create_publisher(Vector3Stamped, "impact", EVENT)
        node.create_subscription(Odometry, "mocap/odom", self._take_pose, POSE_SUBSCRIBED)

    def take(self, telemetry: Telemetry) -> None:
        """Publishes the newest hit where it is a new one."""
        before, self._counted = self._counted, (telemetry.boot, telemetry.impacts)
        if before is None or before[0] != telemetry.boot:
            return
        new = (telemetry.impacts - before[1]) % COUNTS
        if new == 0:
            return
        told = self._publish(telemetry)
        self.published += told
        self.missed += new - told

    def _publish(self, telemetry: Telemetry) -> bool:
        now = self._clock.now(seconds(self._local))
        if now is None or telemetry.impact_age == NEVER:
            return False
        stamp = now - telemetry.impact_age * 1e-3
        # the newest pose will do for the heading where none is as new as the hit
        state = self._history.at(stamp) or self._newest
        c, s = math.cos(state.yaw), math.sin(state.yaw)
        x, y = telemetry.impact
        self._publisher.publish(impact_to_message(stamp, np.array([c * x - s * y, s * x + c * y]), self._frames.map))
        return True

    def _take_pose(self, message: Odometry) -> None:
        try:
            self._newest = state_from_odometry(message, self._frames.map, self._frames.base)
        except MessageError:
            return
        self._history.add(self._newest)
        self._clock.received(self._newest.stamp, seconds(self._local))
