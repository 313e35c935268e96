"""controller_node follows the timed path of a planner that is not ours, in a graph without planner_node."""

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import String

from collplan_core.worlds import save_world
from collplan_ros.messages.conversions import seconds_from_stamp, state_from_odometry
from collplan_ros.messages.qos import LATCHED, NEWEST, POSE_SUBSCRIBED
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from fake_robot import hall
from foreign_planner import SPEED, SWING, ForeignPlanner
from omnipuck_sim.node import pacing
from omnipuck_sim.node.simulator_node import SimulatorNode

ONE_POSE = 0.01
"""Simulated time between two poses [s]."""
CLOCK = {"use_sim_time": True}
LONGEST = 30.0
"""For the way to the goal, simulated [s]."""


@pytest.fixture
def graph(ros, tmp_path, monkeypatch):
    """Every node but a planner, in an empty hall, on the simulation's clock: a stall of the machine stops it too."""
    monkeypatch.setattr(pacing, "LONGEST_CATCH_UP", ONE_POSE)
    world = tmp_path / "hall.yaml"
    save_world(hall(), world)
    ros.make(SimulatorNode, {**CLOCK, "simulator.world": str(world), "simulator.speed_factor": 10.0})
    ros.make(MocapNode, CLOCK)
    ros.make(LidarNode, {**CLOCK, "lidar.world": str(world)})
    controller = ros.make(ControllerNode, CLOCK)
    assert ros.wait_until(lambda: controller._loop._sensors.scan_stamp is not None)
    return ros


def test_a_foreign_planner_drives_the_robot_to_its_goal(graph):
    poses = graph.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    commands = graph.listen(Twist, "cmd_vel", NEWEST)
    maneuvers = graph.listen(String, "maneuver", LATCHED)
    statuses = graph.listen(GoalStatus, "goal_status", LATCHED)
    plans = graph.listen(Path, "plan", NEWEST)
    assert graph.wait_until(lambda: poses and commands and maneuvers)
    goal = hall().goal
    planner = graph.make(ForeignPlanner, CLOCK, goal=goal)

    def driven() -> np.ndarray:
        return np.array([state_from_odometry(pose, "map", "base_link").position for pose in poses])

    reached = graph.wait_until(
        lambda: statuses and statuses[-1].status == GoalStatus.STATUS_SUCCEEDED,
        timeout=LONGEST,
        clock=lambda: seconds_from_stamp(poses[-1].header.stamp),
    )
    assert reached, driven()[-1]
    path = driven()
    apart = np.linalg.norm(path[:, None] - planner.curve[None], axis=2).min(axis=1)
    length = np.hypot(*np.diff(planner.curve, axis=0).T).sum()
    taken = seconds_from_stamp(poses[-1].header.stamp) - seconds_from_stamp(plans[0].header.stamp)
    assert taken == pytest.approx(length / SPEED, rel=0.2)
    assert apart.max() < 0.1
    assert path[:, 1].max() > 0.8 * SWING
    assert path[:, 1].min() < -0.8 * SWING
    assert {m.data for m in maneuvers} == {"free_space", "stopped"}
    commands.clear()
    assert graph.wait_until(lambda: len(commands) >= 2)
    assert (commands[-1].linear.x, commands[-1].linear.y, commands[-1].angular.z) == (0.0, 0.0, 0.0)
