"""What planner and controller hear from mocap_node and lidar_node, without either: a robot that stands in a world."""

import math

import numpy as np
from nav_msgs.msg import Odometry
from rclpy.clock import Clock, ClockType
from sensor_msgs.msg import LaserScan

from collplan_core.local_map import build_local_map
from collplan_core.parameters import Lidar, Settings
from collplan_core.planners import planner_for
from collplan_core.state import State
from collplan_core.worlds import parse_world
from collplan_core.worlds.raycast import simulate_scan
from collplan_ros.messages.conversions import scan_to_message, state_to_odometry
from collplan_ros.messages.qos import POSE_PUBLISHED, SENSOR_DATA

PERIOD = 0.02
SCAN_EVERY = 3
LIDAR = Lidar(n_beams=180)
GOAL = np.array([2.0, 0.0])


def hall(obstacle_y: float | None = None):
    """A walled hall, 3 m by 2 m; a disc of 0.15 m stands 0.55 m ahead of the start where one is asked for."""
    circles = [] if obstacle_y is None else [{"center": [0.55, obstacle_y], "radius": 0.15}]
    ends = {"start": [0.0, 0.0], "goal": [2.0, 0.0]}
    return parse_world({"name": "hall", "bounds": [-0.5, -1.0, 2.5, 1.0], "circles": circles, **ends}, "hall")


def planned(settings: Settings):
    """The second cycle of a strategy towards GOAL, at 3.25 s: map, plan, remembered boundaries."""
    planner, memory = planner_for(settings.planner.strategy), None
    for stamp in (3.20, 3.25):
        state = State(stamp, np.array([0.1, 0.2]), np.array([0.3, 0.0]), 0.4)
        local_map = build_local_map(simulate_scan(hall(0.1), state, LIDAR), state, settings.robot, settings.local_map)
        plan, memory = planner.plan(memory, local_map, state, GOAL, settings)
    return local_map, plan, planner.boundaries(memory)


class FakeRobot:
    """Publishes poses and scans while the test waits; stamps go on by themselves, whatever the machine's load."""

    def __init__(self, ros, world, yaw: float = 0.0) -> None:
        self.world, self.yaw, self._ros = world, yaw, ros
        self.position, self.velocity = np.array([0.0, 0.0]), np.zeros(2)
        self.stamp = 100.0
        self.poses_on = self.scans_on = True
        self.poses = ros.probe.create_publisher(Odometry, "mocap/odom", POSE_PUBLISHED)
        self.scans = ros.probe.create_publisher(LaserScan, "scan", SENSOR_DATA)
        self._ticks, self._heard = 0, 0.0
        ros.probe.create_timer(PERIOD, self._tick, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def is_heard(self) -> bool:
        """Whether somebody listens to poses and scans, and a few have come since the first was published."""
        matched = self.poses.get_subscription_count() and self.scans.get_subscription_count()
        self._heard = (self._heard or self.stamp) if matched else 0.0
        return bool(matched) and self.stamp > self._heard + 5 * SCAN_EVERY * PERIOD

    @property
    def state(self) -> State:
        return State(self.stamp, self.position, self.velocity, self.yaw)

    def pose(self) -> Odometry:
        return state_to_odometry(self.state, "map", "base_link")

    def scan(self) -> LaserScan:
        return scan_to_message(simulate_scan(self.world, self.state, LIDAR), "base_link")

    def bad_scans(self) -> list[LaserScan]:
        """Empty, nothing measured, angles that do not fit, no step, negative ranges, limits the wrong way round."""
        faults = (
            {"ranges": []},
            {"ranges": [math.nan] * LIDAR.n_beams},
            {"angle_increment": 0.5},
            {"angle_increment": 0.0},
            {"ranges": [-1.0] * LIDAR.n_beams},
            {"range_max": 0.0},
        )
        scans = [self.scan() for _ in faults]
        for scan, fault in zip(scans, faults, strict=True):
            for name, value in fault.items():
                setattr(scan, name, value)
        return scans

    def bad_poses(self) -> list[Odometry]:
        """In another frame, not a number, without an orientation."""
        poses = [self.pose() for _ in range(3)]
        poses[0].header.frame_id = "odom"
        poses[1].pose.pose.position.x = math.nan
        poses[2].pose.pose.orientation.w = poses[2].pose.pose.orientation.z = 0.0
        return poses

    def send_bad(self) -> None:
        """Sends each bad pose and scan, and no good ones any more."""
        self.scans_on = self.poses_on = False
        for publisher, messages in ((self.poses, self.bad_poses()), (self.scans, self.bad_scans())):
            for message in messages:
                publisher.publish(message)
                self._ros.spin(0.02)

    def _tick(self) -> None:
        self._ticks += 1
        self.stamp = 100.0 + PERIOD * self._ticks
        if self.poses_on:
            self.poses.publish(self.pose())
        if self.scans_on and self._ticks % SCAN_EVERY == 0:
            self.scans.publish(self.scan())
