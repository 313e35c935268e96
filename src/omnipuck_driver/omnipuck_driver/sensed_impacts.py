"""Impacts that the ring has sensed, by the counts of the telemetry."""

import numpy as np
from nav_msgs.msg import Odometry
from rclpy.clock import Clock
from rclpy.node import Node

from collplan_core.parameters import Settings
from collplan_core.plane import rotate
from collplan_ros.messages.qos import POSE_SUBSCRIBED
from collplan_ros.node_kit.inputs import Inputs
from collplan_ros.nodes.felt_impacts import FeltImpacts
from omnipuck_driver.messages import NEVER, Telemetry

COUNTS = 1 << 16


class SensedImpacts:
    """Publishes impacts of the telemetry, turned from the body into the map frame by the poses of `mocap/odom`."""

    def __init__(self, node: Node, inputs: Inputs, settings: Settings, clock: Clock) -> None:
        """Publishes through `node`, subscribes through `inputs`."""
        self.published = 0
        self.missed = 0  # without pose or telemetry, older than the poses kept, or without a change of velocity
        self._counted: tuple[int, int] | None = None
        self._felt = FeltImpacts(node, settings, clock)
        inputs.listen(Odometry, "mocap/odom", self._take_pose, POSE_SUBSCRIBED, kind="pose", raw=True)

    def take(self, telemetry: Telemetry) -> None:
        """Publishes the impact in telemetry where it is a new one."""
        before, self._counted = self._counted, (telemetry.boot, telemetry.impacts)
        if before is None or before[0] != telemetry.boot:
            return
        new = (telemetry.impacts - before[1]) % COUNTS
        if new == 0:
            return
        published = telemetry.impact_age != NEVER and self._felt.publish(
            telemetry.impact_age * 1e-3, lambda state: np.array(rotate(*telemetry.impact, state.yaw))
        )
        self.published += published
        self.missed += new - published

    def _take_pose(self, raw: bytes) -> None:
        self._felt.take_pose(raw)
