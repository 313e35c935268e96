"""Impacts that the ring has sensed, on `impact` and `impact/contact`: in the map frame and the poses' time."""

import numpy as np
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2

from collplan_core.ages import PosesClock
from collplan_core.impact import RING, measured_impact
from collplan_core.parameters import Settings
from collplan_core.plane import rotate
from collplan_core.sensing.pose_history import PoseHistory
from collplan_core.state import State
from collplan_ros.messages.conversions import impact_to_message
from collplan_ros.messages.planner_clouds import impact_to_cloud
from collplan_ros.messages.qos import EVENT, POSE_SUBSCRIBED
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.node_kit.clock import seconds
from collplan_ros.node_kit.inputs import Inputs
from omnipuck_driver.messages import NEVER, Telemetry

COUNTS = 1 << 16


class SensedImpacts:
    """Publishes impacts of the telemetry, turned from the body frame into the map frame by the poses of `mocap/odom`.

    Attributes:
        published: impacts published.
        missed: impacts for which a pose, or their telemetry, was missing, that are older than the poses kept, or that
            changed no velocity.
    """

    def __init__(self, node: Node, inputs: Inputs, settings: Settings, clock: Clock) -> None:
        """Publishes through `node`, subscribes through `inputs`."""
        self.published = 0
        self.missed = 0
        self._frames = settings.frames
        self._radius = settings.robot.radius
        self._history = PoseHistory(settings.limits.pose_history)
        self._clock = PosesClock()
        self._counted: tuple[int, int] | None = None
        self._local = clock
        self._newest: State | None = None
        self._contact = node.create_publisher(PointCloud2, "impact/contact", EVENT)
        self._impact = node.create_publisher(Vector3Stamped, "impact", EVENT)
        inputs.listen(Odometry, "mocap/odom", self._take_pose, POSE_SUBSCRIBED, kind="pose", raw=True)

    def take(self, telemetry: Telemetry) -> None:
        """Publishes the impact in telemetry where it is a new one."""
        before, self._counted = self._counted, (telemetry.boot, telemetry.impacts)
        if before is None or before[0] != telemetry.boot:
            return
        new = (telemetry.impacts - before[1]) % COUNTS
        if new == 0:
            return
        published = self._publish(telemetry)
        self.published += published
        self.missed += new - published

    def _publish(self, telemetry: Telemetry) -> bool:
        now = self._clock.now(seconds(self._local))
        if now is None or telemetry.impact_age == NEVER or not any(telemetry.impact):
            return False
        stamp = now - telemetry.impact_age * 1e-3
        state = self._history.at(stamp)
        if state is None and self._newest is not None and self._newest.stamp <= stamp:
            # no pose is as new as the impact: the newest one leads to it
            state = self._newest
        if state is None:
            return False
        change = np.array(rotate(*telemetry.impact, state.yaw))
        center = state.position + (stamp - state.stamp) * state.velocity
        impact = measured_impact(stamp, center, state.velocity, change, self._radius, RING)
        self._contact.publish(impact_to_cloud(impact, self._frames.map))
        self._impact.publish(impact_to_message(stamp, change, self._frames.map))
        return True

    def _take_pose(self, raw: bytes) -> None:
        state = state_from_bytes(raw, self._frames.map, self._frames.base)
        self._newest = state
        self._history.add(state)
        self._clock.received(state.stamp, seconds(self._local))
