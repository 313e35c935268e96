"""All nodes in one process, driving the simulated robot."""

import numpy as np
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry, Path
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import LaserScan
from std_msgs.msg import String
from straight_planner import STRAIGHT

from collplan_core.planners import PLANNERS
from collplan_core.state import State
from collplan_core.worlds import load_world, save_world
from collplan_ros.messages.conversions import goal_to_message
from collplan_ros.messages.qos import EVENT, LATCHED, NEWEST, POSE_SUBSCRIBED, SENSOR_DATA
from collplan_ros.messages.raw_reading import plan_from_path, state_from_bytes
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from collplan_ros.nodes.planner_node import PlannerNode
from fake_robot import hall
from omnipuck_sim.node.simulator_node import SimulatorNode


class Graph:
    """The whole loop in a world that simulator and lidar alone are told."""

    def __init__(self, ros, world: str, **parameters) -> None:
        self.ros = ros
        clock = {"use_sim_time": True}
        shared = {**clock, **{key.replace("__", "."): value for key, value in parameters.items()}}
        simulation = {"simulator.world": world, "simulator.seed": 3, "simulator.speed_factor": 0.0}
        self.odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
        self.commands = ros.listen(Twist, "cmd_vel", NEWEST)
        self.plans = ros.listen(Path, "plan", NEWEST)
        self.maneuvers = ros.listen(String, "maneuver", LATCHED)
        self.statuses = ros.listen(GoalStatus, "goal_status", LATCHED)
        ros.make(SimulatorNode, {**clock, **simulation})
        ros.make(MocapNode, clock)
        ros.make(LidarNode, {**clock, "lidar.world": world})
        self.planner = ros.make(PlannerNode, shared)
        # all nodes share a thread here, and poses wait in its queues
        ros.make(ControllerNode, {**shared, "limits.motion_delay": 0.4})
        self.goals = ros.publisher(PoseStamped, "goal_pose", EVENT)
        scans = ros.listen(LaserScan, "scan", SENSOR_DATA)
        # only once it hears of goals is one new to the robot, and lets it move
        assert ros.wait_until(lambda: len(scans) > 5 and ros.probe.count_subscribers("goal_status") >= 3)

    def send_goal(self, goal) -> None:
        self.goals.publish(goal_to_message(goal, "map"))

    @property
    def state(self) -> State:
        return state_from_bytes(serialize_message(self.odometry[-1]), "map", "base_link")

    @property
    def status(self) -> int | None:
        return self.statuses[-1].status if self.statuses else None


def test_each_strategy_takes_over_from_any_other_while_the_robot_drives(ros):
    """The strategy is set at planner_node alone."""
    few = {"time_to_goal__start_proposals": 20, "time_to_goal__proposals": 50, "time_to_goal__time_budget": 1.0}
    graph = Graph(ros, "corridor", planner__map_period=0.1, **few)
    costs = ros.listen(DiagnosticArray, "planner/costs", EVENT)

    def plans_by(strategy) -> int:
        return sum(value.value == strategy for each in costs for value in each.status[0].values)

    graph.send_goal(load_world("corridor").goal)
    for strategy in ("harness", "bounce", "high_risk", "tolerate", "avoid", "low_risk", "stop_guarantee"):
        before = plans_by(strategy)
        assert graph.planner.set_parameters([Parameter("planner.strategy", value=strategy)])[0].successful
        planned = ros.wait_until(
            lambda strategy=strategy, before=before: plans_by(strategy) >= before + 2, clock=lambda: graph.state.stamp
        )
        assert planned, strategy
        assert graph.status == GoalStatus.STATUS_EXECUTING, "the way is too short for seven strategies"
    maneuvers = [maneuver.data for maneuver in graph.maneuvers]
    assert "stopped" not in maneuvers[maneuvers.index("free_space") :], maneuvers
    # it may have touched a wall just now
    assert ros.wait_until(lambda: np.hypot(*graph.state.velocity) > 0.2, clock=lambda: graph.state.stamp)
    assert ros.wait_until(lambda: graph.status == GoalStatus.STATUS_SUCCEEDED, clock=lambda: graph.state.stamp)
    assert np.hypot(*(graph.state.position - load_world("corridor").goal)) < 0.25
    graph.commands.clear()
    assert ros.wait_until(lambda: len(graph.commands) >= 2 and graph.maneuvers[-1].data == "stopped")
    last = graph.commands[-1]
    assert (last.linear.x, last.linear.y, last.angular.z) == (0.0, 0.0, 0.0)


def test_a_third_planner_drives_through_the_graph(ros, tmp_path, monkeypatch):
    """Straight to the goal: a folder and a line in the table of planners, and no node knows of it."""
    monkeypatch.setitem(PLANNERS, "custom", STRAIGHT)
    path = tmp_path / "hall.yaml"
    save_world(hall(), path)
    graph = Graph(ros, str(path), planner__strategy="custom")
    graph.send_goal(hall().goal)
    assert ros.wait_until(lambda: graph.status == GoalStatus.STATUS_SUCCEEDED, clock=lambda: graph.state.stamp)
    assert {m.data for m in graph.maneuvers} <= {"free_space", "stopped"}
    ends = [plan_from_path(serialize_message(plan), "map").positions[-1] for plan in graph.plans]
    np.testing.assert_allclose(ends, np.tile(hall().goal, (len(ends), 1)), atol=1e-6)
