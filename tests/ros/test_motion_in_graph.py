"""Every node but a planner, which is somebody else's: to its goal, and with a motion capture that is false."""

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from collplan_core.worlds import save_world
from collplan_ros.messages.qos import LATCHED, NEWEST, POSE_SUBSCRIBED, SENSOR_DATA
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.reading import seconds_from_stamp
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from fake_robot import hall
from foreign_planner import SPEED, SWING, ForeignPlanner
from omnipuck_sim.node.simulator_node import SimulatorNode

"""From the first false pose to the command to stand, simulated [s]."""
"""Simulated time between two poses [s]."""
CLOCK = {"use_sim_time": True}
STAMPED = {**CLOCK, "controller.stamped_cmd_vel": True}


class SimulatedHall:
    """The graph without a planner, and what it says, in simulated time that waits for it."""

    def __init__(self, ros, folder) -> None:
        self.ros = ros
        world = folder / "hall.yaml"
        save_world(hall(), world)
        speed = {"simulator.world": str(world), "simulator.speed_factor": 0.0}
        self.simulator = ros.make(SimulatorNode, {**STAMPED, **speed})
        ros.make(MocapNode, CLOCK)
        ros.make(LidarNode, {**CLOCK, "lidar.world": str(world)})
        self.controller = ros.make(ControllerNode, STAMPED)
        scans = ros.listen(LaserScan, "scan", SENSOR_DATA)
        self.poses = ros.listen(PoseStamped, "mocap/pose", POSE_SUBSCRIBED)
        self.commands = ros.listen(TwistStamped, "cmd_vel", NEWEST)
        self.states = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
        assert ros.wait_until(lambda: self.poses and self.commands and scans)

    @property
    def now(self) -> float:
        """The newest pose's time [s, simulation]."""
        return seconds_from_stamp(self.poses[-1].header.stamp)

    @property
    def said(self) -> str:
        """What the controller said last of its state."""
        return self.states[-1].message if self.states else "no state"

    def until(self, condition, patience: float = 20.0) -> None:
        """Waits at most `patience` [s] on the simulation's clock."""
        assert self.ros.wait_until(condition, patience, lambda: self.now), self.said

    @property
    def speed(self) -> float:
        """Of the newest command [m/s]."""
        linear = self.commands[-1].twist.linear
        return abs(linear.x) + abs(linear.y)


@pytest.fixture
def graph(ros, tmp_path):
    graph = SimulatedHall(ros, tmp_path)
    graph.delays = ros.listen(Float64, "controller/motion_delay", LATCHED)
    # this planner has its goal before the robot could know that it is a new one
    assert ros.call(Trigger, "resume").success
    graph.planner = ros.make(ForeignPlanner, CLOCK, goal=hall().goal)
    return graph


def test_a_foreign_planner_drives_the_robot_to_its_goal(graph):
    poses = graph.ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    maneuvers = graph.ros.listen(String, "maneuver", LATCHED)
    statuses = graph.ros.listen(GoalStatus, "goal_status", LATCHED)
    graph.until(lambda: statuses and statuses[-1].status == GoalStatus.STATUS_SUCCEEDED, 30.0)
    path = np.array([state_from_bytes(serialize_message(pose), "map", "base_link").position for pose in poses])
    apart = np.linalg.norm(path[:, None] - graph.planner.curve[None], axis=2).min(axis=1)
    length = np.hypot(*np.diff(graph.planner.curve, axis=0).T).sum()
    taken = seconds_from_stamp(poses[-1].header.stamp) - seconds_from_stamp(poses[0].header.stamp)
    assert taken == pytest.approx(length / SPEED, rel=0.2)
    assert apart.max() < 0.1
    assert path[:, 1].max() > 0.8 * SWING
    assert path[:, 1].min() < -0.8 * SWING
    assert {m.data for m in maneuvers} <= {"free_space", "stopped"}
    assert graph.delays[-1].data < 0.1
    assert "held" not in graph.said
    graph.until(lambda: graph.speed == 0.0)
