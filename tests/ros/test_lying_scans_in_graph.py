"""The whole graph on a simulated robot whose LIDAR begins to lie: it stands in time, and until a person lets it go on.

Simulator, motion capture, LIDAR, planner and controller are those that a user runs; what lies stands between LIDAR and
the rest. All times are by the simulation's clock, which the controller follows.
"""

import math

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, Vector3
from lying_scans import LIES, SPEED, Lie
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Trigger

from collplan_core.control.interlock import LONGEST_FAULT
from collplan_core.parameters import Settings
from collplan_core.planners import map_period_of
from collplan_core.scan import Scan
from collplan_ros.messages.conversions import goal_to_message, scan_to_message, seconds_from_stamp
from collplan_ros.messages.qos import EVENT, SENSOR_DATA
from collplan_ros.messages.reading import scan_from_message
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.planner_node import PlannerNode
from fake_robot import hall
from simulated_hall import CLOCK, ONE_POSE, STAMPED, SimulatedHall, speed_of

REACTION = 0.2
"""Longest time from the first scan that lies to the command to stand, beside the time between two plans [s]."""
TRUE_SCANS = "scan/true"
TOLD_APART = ("nothing near", "late 0.5 s")
"""By the ranges and by the stamp; that the others are, trials without ROS show."""


class LyingLidar(Node):
    """Passes scans on as they are, or as the lie says that has begun."""

    def __init__(self, **kwargs) -> None:
        super().__init__("lying_lidar", **kwargs)
        self.begun: float | None = None
        self._lie: Lie | None = None
        self._first = 0
        self._scans: list[Scan] = []
        self._out = self.create_publisher(LaserScan, "scan", SENSOR_DATA)
        self.create_subscription(LaserScan, TRUE_SCANS, self._pass_on, SENSOR_DATA)

    def lie(self, lie: Lie | None) -> None:
        """Begins to lie with the next scan, or to tell the truth again."""
        self._lie, self._first, self.begun = lie, len(self._scans), None

    def _pass_on(self, message: LaserScan) -> None:
        self._scans.append(scan_from_message(message, "base_link"))
        told: Scan | None = self._scans[-1]
        if self._lie is not None:
            told = self._lie(self._scans, self._first, np.random.default_rng(0))
            if self.begun is None:
                self.begun = 1e-9 * self.get_clock().now().nanoseconds
        if told is not None:
            self._out.publish(scan_to_message(told, "base_link"))


class Hall(SimulatedHall):
    """The graph with a planner and a LIDAR that can lie."""

    def __init__(self, ros, folder, strategy: str) -> None:
        super().__init__(ros, folder, self._lidar)
        ros.make(PlannerNode, {**STAMPED, "planner.strategy": strategy})
        self._goals = ros.publisher(PoseStamped, "goal_pose", EVENT)
        self._truth = ros.listen(Odometry, "ground_truth/odom", EVENT)
        # only once it hears of goals is one new to the robot, and lets it move
        assert ros.wait_until(lambda: ros.probe.count_subscribers("goal_status") >= 2)
        self.pass_time(0.5)

    def _lidar(self, parameters) -> LyingLidar:
        true = ["--ros-args", "-r", f"scan:={TRUE_SCANS}"]
        self.ros.make(LidarNode, parameters, cli_args=true)
        return self.ros.make(LyingLidar, CLOCK)

    def give_goal(self) -> None:
        """The goal at the hall's other end."""
        self._goals.publish(goal_to_message(hall().goal, "map"))

    @property
    def true_speed(self) -> float:
        """Of the robot [m/s]."""
        linear = self._truth[-1].twist.twist.linear if self._truth else Vector3()
        return math.hypot(linear.x, linear.y)

    def stood(self) -> float | None:
        """When the robot was first commanded to stand after the lie had begun [s]."""
        begun = self.lidar.begun
        stamps = ((seconds_from_stamp(each.header.stamp), speed_of(each)) for each in self.commands)
        return next((stamp for stamp, speed in stamps if begun is not None and stamp >= begun and speed == 0.0), None)

    def stands(self, duration: float) -> bool:
        """Whether each command of so much simulated time [s] is zero."""
        n = len(self.commands)
        self.pass_time(duration)
        return len(self.commands) > n and not any(map(speed_of, self.commands[n:]))


@pytest.mark.parametrize("name", TOLD_APART)
def test_a_lie_stops_the_robot_in_time_and_one_that_lasts_until_a_person_lets_it_go_on(ros, tmp_path, name):
    graph = Hall(ros, tmp_path, "avoid")
    graph.give_goal()
    graph.until(lambda: graph.true_speed >= SPEED)
    graph.lidar.lie(LIES[name])
    graph.until(lambda: graph.stood() is not None, 5.0)
    longest = map_period_of(Settings().with_values({"planner.strategy": "avoid"})) + REACTION
    assert graph.stood() - graph.lidar.begun <= longest + ONE_POSE
    graph.until(lambda: "scan" in graph.said, 1.0)
    assert graph.stands(LONGEST_FAULT + 0.5)
    assert "held: scan" in graph.said
    graph.lidar.lie(None)
    assert graph.stands(LONGEST_FAULT + 0.5)
    assert graph.ros.call(Trigger, "resume").success
    graph.until(lambda: graph.true_speed > 0.1)
