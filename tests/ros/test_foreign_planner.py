"""controller_node follows the timed path of a planner that is not ours, in a graph without planner_node."""

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import String
from std_srvs.srv import Trigger

from collplan_ros.messages.conversions import seconds_from_stamp, state_from_odometry
from collplan_ros.messages.qos import LATCHED, NEWEST, POSE_SUBSCRIBED
from fake_robot import hall
from foreign_planner import SPEED, SWING, ForeignPlanner
from simulated_hall import CLOCK, SimulatedHall

LONGEST = 30.0
"""For the way to the goal, simulated [s]."""


@pytest.fixture
def graph(ros, tmp_path):
    """Every node but a planner, in an empty hall, on the simulation's clock: a stall of the machine stops it too."""
    hall = SimulatedHall(ros, tmp_path)
    # this planner has its goal before the robot could know that it is a new one
    assert ros.call(Trigger, "resume").success
    return hall


def test_a_foreign_planner_drives_the_robot_to_its_goal(graph):
    ros, commands = graph.ros, graph.commands
    poses = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    maneuvers = ros.listen(String, "maneuver", LATCHED)
    statuses = ros.listen(GoalStatus, "goal_status", LATCHED)
    plans = ros.listen(Path, "plan", NEWEST)
    assert ros.wait_until(lambda: poses and commands and maneuvers)
    goal = hall().goal
    planner = ros.make(ForeignPlanner, CLOCK, goal=goal)

    def driven() -> np.ndarray:
        return np.array([state_from_odometry(pose, "map", "base_link").position for pose in poses])

    reached = ros.wait_until(
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
    assert ros.wait_until(lambda: len(commands) >= 2)
    last = commands[-1].twist
    assert (last.linear.x, last.linear.y, last.angular.z) == (0.0, 0.0, 0.0)
