"""Impacts that a robot feels, on `impact` and `impact/contact`: in the map frame and the poses' time."""

from collections.abc import Callable

import numpy as np
from geometry_msgs.msg import Vector3Stamped
from rclpy.clock import Clock
from rclpy.node import Node
from sensor_msgs.msg import PointCloud2

from collplan_core.ages import PosesClock
from collplan_core.impact import RING, measured_impact
from collplan_core.parameters import Settings
from collplan_core.poses.pose_history import PoseHistory
from collplan_core.state import State
from collplan_ros.messages.conversions import impact_to_message
from collplan_ros.messages.planner_clouds import impact_to_cloud
from collplan_ros.messages.qos import EVENT
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.node_kit.clock import seconds


class FeltImpacts:
    """Publishes impacts at the poses that it is given; `newest` is the state of the last, None before the first."""

    def __init__(self, node: Node, settings: Settings, clock: Clock) -> None:
        """Publishes through `node`; `clock` is that of the ages."""
        self._frames = settings.frames
        self._radius = settings.robot.radius
        self._history = PoseHistory(settings.limits.pose_history)
        self._clock = PosesClock()
        self._local = clock
        self.newest: State | None = None
        self._contact = node.create_publisher(PointCloud2, "impact/contact", EVENT)
        self._impact = node.create_publisher(Vector3Stamped, "impact", EVENT)

    def publish(self, age: float, change_at: Callable[[State], np.ndarray]) -> bool:
        """Publishes an impact of this age [s]; returns whether a pose of that time is known and a velocity changed.

        `change_at` gives the change of velocity (2,) [m/s, world frame] of the robot in a state.
        """
        now = self._clock.now(seconds(self._local))
        if now is None:
            return False
        stamp = now - age
        state = self._history.at(stamp)
        if state is None and self.newest is not None and self.newest.stamp <= stamp:
            # no pose is as new as the impact: the newest one leads to it
            state = self.newest
        change = np.zeros(2) if state is None else change_at(state)
        if state is None or not change.any() or not np.isfinite(change).all():
            return False
        center = state.position + (stamp - state.stamp) * state.velocity
        impact = measured_impact(stamp, center, state.velocity, change, self._radius, RING)
        self._contact.publish(impact_to_cloud(impact, self._frames.map))
        self._impact.publish(impact_to_message(stamp, change, self._frames.map))
        return True

    def take_pose(self, raw: bytes) -> State:
        """Takes and returns the state in a serialized message of `mocap/odom`; raises MessageError."""
        state = state_from_bytes(raw, self._frames.map, self._frames.base)
        self.newest = state
        self._history.add(state)
        self._clock.received(state.stamp, seconds(self._local))
        return state
