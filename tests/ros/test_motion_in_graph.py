"""Every node but a planner, which is somebody else's: to its goal."""

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import TwistStamped
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

CLOCK = {"use_sim_time": True}


def test_a_foreign_planner_drives_the_robot_to_its_goal(ros, tmp_path):
    world, stamped = tmp_path / "hall.yaml", {**CLOCK, "controller.stamped_cmd_vel": True}
    save_world(hall(), world)
    ros.make(SimulatorNode, {**stamped, "simulator.world": str(world), "simulator.speed_factor": 0.0})
    ros.make(MocapNode, CLOCK)
    ros.make(LidarNode, {**CLOCK, "lidar.world": str(world)})
    ros.make(ControllerNode, stamped)
    scans, poses = ros.listen(LaserScan, "scan", SENSOR_DATA), ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    commands = ros.listen(TwistStamped, "cmd_vel", NEWEST)
    states = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
    maneuvers, statuses = ros.listen(String, "maneuver", LATCHED), ros.listen(GoalStatus, "goal_status", LATCHED)
    delays = ros.listen(Float64, "controller/motion_delay", LATCHED)
    assert ros.wait_until(lambda: poses and commands and scans)
    # this planner has its goal before the robot could know that it is a new one
    assert ros.call(Trigger, "resume").success
    poses.clear()
    planner = ros.make(ForeignPlanner, CLOCK, goal=hall().goal)
    assert ros.wait_until(lambda: poses)

    def until(condition) -> None:
        simulated = lambda: seconds_from_stamp(poses[-1].header.stamp)  # noqa: E731
        assert ros.wait_until(condition, 30.0, simulated), states and states[-1].message

    until(lambda: statuses and statuses[-1].status == GoalStatus.STATUS_SUCCEEDED)
    path = np.array([state_from_bytes(serialize_message(pose), "map", "base_link").position for pose in poses])
    apart = np.linalg.norm(path[:, None] - planner.curve[None], axis=2).min(axis=1)
    length = np.hypot(*np.diff(planner.curve, axis=0).T).sum()
    taken = seconds_from_stamp(poses[-1].header.stamp) - seconds_from_stamp(poses[0].header.stamp)
    assert taken == pytest.approx(length / SPEED, rel=0.2)
    assert apart.max() < 0.1
    assert path[:, 1].max() > 0.8 * SWING
    assert path[:, 1].min() < -0.8 * SWING
    assert {m.data for m in maneuvers} <= {"free_space", "stopped"}
    assert delays[-1].data < 0.1
    assert "held" not in states[-1].message
    until(lambda: not commands[-1].twist.linear.x and not commands[-1].twist.linear.y)
