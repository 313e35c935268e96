"""Somebody else's robot that feels hits, of which it tells the side alone: plain rclpy, not a line of collplan.

The side and the velocity before it make an impact, as far as they can: the change along the way into the obstacle.
"""

import math

from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

REBOUND = 0.6
"""Share of the speed into the obstacle that the robot keeps, away from it."""


class HitAdapter(Node):
    """Makes `impact` of `hit`, a robomaster_msgs/ArmorHit, with the velocity in `mocap/odom`."""

    def __init__(self, hits: type, **kwargs) -> None:
        super().__init__("hit_adapter", **kwargs)
        self._sides = {
            hits.BOTTOM_FRONT: (1.0, 0.0),
            hits.BOTTOM_BACK: (-1.0, 0.0),
            hits.BOTTOM_LEFT: (0.0, 1.0),
            hits.BOTTOM_RIGHT: (0.0, -1.0),
        }
        self._felt = hits.COLLISION
        self._odometry: Odometry | None = None
        self._impacts = self.create_publisher(Vector3Stamped, "impact", 50)
        self.create_subscription(Odometry, "mocap/odom", self._on_odometry, 10)
        self.create_subscription(hits, "hit", self._on_hit, 10)

    def _on_odometry(self, message: Odometry) -> None:
        self._odometry = message

    def _on_hit(self, message) -> None:
        if message.type != self._felt or self._odometry is None:
            return
        sides = [side for bit, side in self._sides.items() if message.location & bit]
        x, y = sum(side[0] for side in sides), sum(side[1] for side in sides)
        length = math.hypot(x, y)
        if length == 0.0:
            return
        moving = self._odometry.twist.twist.linear
        into = (moving.x * x + moving.y * y) / length
        if into > 0.0:
            self._publish(-(1.0 + REBOUND) * into * x / length, -(1.0 + REBOUND) * into * y / length)

    def _publish(self, ahead: float, left: float) -> None:
        """Publishes a change of velocity in the body frame [m/s]."""
        turn = self._odometry.pose.pose.orientation
        yaw = 2.0 * math.atan2(turn.z, turn.w)
        # the robot's own clock need not be that of the poses
        impact = Vector3Stamped(header=self._odometry.header)
        impact.vector.x = math.cos(yaw) * ahead - math.sin(yaw) * left
        impact.vector.y = math.sin(yaw) * ahead + math.cos(yaw) * left
        self._impacts.publish(impact)
