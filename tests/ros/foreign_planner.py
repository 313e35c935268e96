"""Somebody else's planner: plain rclpy, not a line of collplan. It publishes timed paths and says when it is done."""

import uuid

import numpy as np
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.time import Time

PERIOD = 0.23
"""Between two paths [s]; most of them begin between two scans."""
SPEED = 0.5
"""[m/s]"""
SWING = 0.3
"""How far the S swings to either side of the straight line [m]."""
JOIN = 0.2
"""Along so much of the S a robot beside it is led back onto it [m]."""
ARRIVED = 0.1
"""[m]"""


def s_curve(start: np.ndarray, goal: np.ndarray, count: int = 200) -> np.ndarray:
    """(count, 2) points [m] from start to goal (2,), first to the left of the straight line and then to its right."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    way = goal - start
    left = np.array([-way[1], way[0]]) / np.hypot(*way)
    return start + share * way + SWING * np.sin(2.0 * np.pi * share) * left


class ForeignPlanner(Node):
    """Leads the robot along an S from where it is first seen to a goal of its own."""

    def __init__(self, goal: np.ndarray, **kwargs) -> None:
        super().__init__("foreign_planner", **kwargs)
        self.goal = np.asarray(goal, dtype=float)
        self.curve: np.ndarray | None = None
        self._pose: Odometry | None = None
        self._status = GoalStatus()
        self._status.goal_info.goal_id.uuid = np.frombuffer(uuid.uuid4().bytes, dtype=np.uint8)
        self.create_subscription(Odometry, "mocap/odom", self._on_pose, 10)
        self._plans = self.create_publisher(Path, "plan", 1)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._statuses = self.create_publisher(GoalStatus, "goal_status", latched)
        self._statuses.publish(GoalStatus())  # no goal yet: the first one that comes after it is a new one
        self.create_timer(PERIOD, self._plan)

    def _on_pose(self, message: Odometry) -> None:
        self._pose = message
        if self.curve is None:
            self.curve = s_curve(self._position, self.goal)
            self._status.goal_info.stamp = message.header.stamp
            self._announce(GoalStatus.STATUS_ACCEPTED)
        if np.hypot(*(self.goal - self._position)) < ARRIVED:
            self._announce(GoalStatus.STATUS_SUCCEEDED)

    @property
    def _position(self) -> np.ndarray:
        point = self._pose.pose.pose.position
        return np.array([point.x, point.y])

    def _announce(self, status: int) -> None:
        if status != self._status.status:
            self._status.status = status
            self._statuses.publish(self._status)

    def _plan(self) -> None:
        if self.curve is None or self._status.status == GoalStatus.STATUS_SUCCEEDED:
            return
        self._announce(GoalStatus.STATUS_EXECUTING)
        nearest = int(np.hypot(*(self.curve - self._position).T).argmin())
        rest = self.curve[min(nearest, len(self.curve) - 2) :]
        covered = np.append(0.0, np.cumsum(np.hypot(*np.diff(rest, axis=0).T)))
        path = rest + (self._position - rest[0]) * np.exp(-covered / JOIN)[:, None]
        self._plans.publish(self._timed(path, covered / SPEED))

    def _timed(self, path: np.ndarray, after: np.ndarray) -> Path:
        """Path (n, 2) [m] with the times (n,) [s] after the newest pose at which to be there."""
        header = self._pose.header
        begin = Time.from_msg(header.stamp).nanoseconds
        poses = []
        for (x, y), seconds in zip(path.tolist(), after.tolist(), strict=True):
            pose = PoseStamped()
            pose.header.frame_id = header.frame_id
            pose.header.stamp = Time(nanoseconds=begin + round(1e9 * seconds)).to_msg()
            pose.pose.position.x, pose.pose.position.y = x, y
            poses.append(pose)
        return Path(header=header, poses=poses)
