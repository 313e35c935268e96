"""Every node but a planner, which is somebody else's: to its goal, and with a motion capture that is late or false."""

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.msg import Odometry
from rclpy.parameter import Parameter
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger

from collplan_core.control.motion_monitor import OK
from collplan_ros.messages.conversions import seconds_from_stamp, state_from_odometry
from collplan_ros.messages.qos import LATCHED, POSE_SUBSCRIBED
from fake_robot import hall
from foreign_planner import SPEED, SWING, ForeignPlanner
from node_health import NodeHealth
from simulated_hall import CLOCK, ONE_POSE, SimulatedHall

LIMIT = 0.15
"""From the first false pose to the command to stand, simulated [s]."""


@pytest.fixture
def make_hall(ros, tmp_path):
    def made(**simulation) -> SimulatedHall:
        graph = SimulatedHall(ros, tmp_path, **simulation)
        graph.delays = ros.listen(Float64, "controller/motion_delay", LATCHED)
        # this planner has its goal before the robot could know that it is a new one
        assert ros.call(Trigger, "resume").success
        graph.planner = ros.make(ForeignPlanner, CLOCK, goal=hall().goal)
        return graph

    return made


def test_late_poses_stop_the_robot_and_the_delay_is_published(make_hall):
    graph = make_hall(mocap_latency=0.3)
    graph.until(lambda: "motion comes after its command by 0." in graph.said)
    assert graph.states[-1].level == DiagnosticStatus.WARN
    graph.until(lambda: graph.speed == 0.0)


def test_a_foreign_planner_drives_the_robot_to_its_goal(make_hall):
    graph = make_hall()
    poses = graph.ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    maneuvers = graph.ros.listen(String, "maneuver", LATCHED)
    statuses = graph.ros.listen(GoalStatus, "goal_status", LATCHED)
    graph.until(lambda: statuses and statuses[-1].status == GoalStatus.STATUS_SUCCEEDED, 30.0)
    path = np.array([state_from_odometry(pose, "map", "base_link").position for pose in poses])
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


def test_a_robot_in_its_emergency_stop_is_commanded_zero_and_neither_stuck_nor_reversed(make_hall):
    graph = make_hall()
    graph.until(lambda: graph.poses[-1].pose.position.x > 0.5 and graph.speed > 0.3)
    health = NodeHealth(graph.ros, "/controller_node")
    stop = graph.ros.probe.create_client(Trigger, "estop")
    assert graph.ros.wait_until(stop.service_is_ready)
    stop.call_async(Trigger.Request())
    graph.pass_time(2.0)
    assert graph.ros.wait_until(lambda: health.value("motion"))
    assert health.value("motion") == OK
    assert graph.speed == 0.0
    assert "held: emergency stop" in graph.said


@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        ("yaw_180", "yaw"),
        *(
            pytest.param(*each, marks=pytest.mark.soak)
            for each in (("yaw_90", "yaw"), ("tilt", "tilt"), ("lift", "height"))
        ),
    ],
)
def test_a_false_pose_stops_the_robot_in_time(make_hall, fault, reason):
    graph = make_hall()
    graph.until(lambda: graph.poses[-1].pose.position.x > 0.5 and graph.speed > 0.3)
    begun = graph.now
    graph.simulator.set_parameters([Parameter("simulator.mocap_fault", value=fault)])
    graph.until(lambda: graph.speed == 0.0)
    assert seconds_from_stamp(graph.commands[-1].header.stamp) <= begun + LIMIT + ONE_POSE
    graph.until(lambda: f"pose refused: {reason}" in graph.said)
    graph.simulator.set_parameters([Parameter("simulator.mocap_fault", value="none")])
    graph.until(lambda: graph.speed > 0.3)
