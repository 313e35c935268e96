"""Every node but a planner, in a hall, with a motion capture that is late, or that turns, tips or lifts the robot."""

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, TwistStamped
from rclpy.parameter import Parameter
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from collplan_core.control.motion_monitor import OK
from collplan_core.worlds import save_world
from collplan_ros.messages.conversions import seconds_from_stamp
from collplan_ros.messages.qos import LATCHED, NEWEST, POSE_SUBSCRIBED
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.lidar_node import LidarNode
from collplan_ros.nodes.mocap_node import MocapNode
from fake_robot import hall
from foreign_planner import ForeignPlanner
from omnipuck_sim.node import pacing
from omnipuck_sim.node.simulator_node import SimulatorNode

ONE_POSE = 0.01
"""Simulated time between two poses [s]."""
CLOCK = {"use_sim_time": True}
STAMPED = {**CLOCK, "controller.stamped_cmd_vel": True}
LIMIT = 0.15
"""From the first false pose to the command to stand, simulated [s]."""


class Hall:
    """The graph, and what it says, on the simulation's clock: a stall of the machine stops it too."""

    def __init__(self, ros, folder, **simulation) -> None:
        self.ros = ros
        world = folder / "hall.yaml"
        save_world(hall(), world)
        named = {f"simulator.{key}": value for key, value in simulation.items()}
        speed = {"simulator.world": str(world), "simulator.speed_factor": 10.0}
        self.simulator = ros.make(SimulatorNode, {**STAMPED, **speed, **named})
        ros.make(MocapNode, CLOCK)
        ros.make(LidarNode, {**CLOCK, "lidar.world": str(world)})
        self.controller = ros.make(ControllerNode, STAMPED)
        assert ros.wait_until(lambda: self.controller._loop._sensors.scan_stamp is not None)
        self.poses = ros.listen(PoseStamped, "mocap/pose", POSE_SUBSCRIBED)
        self.commands = ros.listen(TwistStamped, "cmd_vel", NEWEST)
        self.states = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
        self.delays = ros.listen(Float64, "controller/motion_delay", LATCHED)
        assert ros.wait_until(lambda: self.poses and self.commands)
        ros.make(ForeignPlanner, CLOCK, goal=hall().goal)

    def until(self, condition) -> None:
        """Waits on the simulation's clock."""
        reached = self.ros.wait_until(condition, 20.0, lambda: seconds_from_stamp(self.poses[-1].header.stamp))
        assert reached, self.states[-1].message if self.states else "no state"

    def speed(self) -> float:
        linear = self.commands[-1].twist.linear
        return abs(linear.x) + abs(linear.y)


@pytest.fixture
def make_hall(ros, tmp_path, monkeypatch):
    monkeypatch.setattr(pacing, "LONGEST_CATCH_UP", ONE_POSE)
    return lambda **simulation: Hall(ros, tmp_path, **simulation)


def test_late_poses_stop_the_robot_and_the_delay_is_published(make_hall):
    graph = make_hall(mocap_latency=0.3)
    graph.until(lambda: graph.states and "motion comes after its command by 0." in graph.states[-1].message)
    assert graph.states[-1].level == DiagnosticStatus.WARN
    graph.until(lambda: graph.speed() == 0.0)


def test_a_robot_in_time_drives_and_its_delay_is_published(make_hall):
    graph = make_hall()
    graph.until(lambda: graph.poses[-1].pose.position.x > 1.5)
    assert graph.delays
    assert graph.delays[-1].data < 0.1
    assert not graph.controller._loop.held


def test_a_robot_in_its_emergency_stop_is_commanded_zero_and_neither_stuck_nor_reversed(make_hall):
    graph = make_hall()
    graph.until(lambda: graph.poses[-1].pose.position.x > 0.5 and graph.speed() > 0.3)
    verdicts = set()
    stop = graph.ros.probe.create_client(Trigger, "estop")
    assert graph.ros.wait_until(stop.service_is_ready)
    stop.call_async(Trigger.Request())
    begun = seconds_from_stamp(graph.poses[-1].header.stamp)

    def has_lasted(duration: float) -> bool:
        verdicts.add(graph.controller._loop.motion.verdict.kind)
        return seconds_from_stamp(graph.poses[-1].header.stamp) > begun + duration

    graph.until(lambda: has_lasted(2.0))
    assert verdicts == {OK}
    assert graph.speed() == 0.0
    assert graph.states[-1].message.startswith("stands still: held: emergency stop by its service")


@pytest.mark.parametrize(
    ("fault", "reason"), [("yaw_180", "yaw"), ("yaw_90", "yaw"), ("tilt", "tilt"), ("lift", "height")]
)
def test_a_false_pose_stops_the_robot_in_time(make_hall, fault, reason):
    graph = make_hall()
    graph.until(lambda: graph.poses[-1].pose.position.x > 0.5 and graph.speed() > 0.3)
    begun = seconds_from_stamp(graph.poses[-1].header.stamp)
    graph.simulator.set_parameters([Parameter("simulator.mocap_fault", value=fault)])
    graph.until(lambda: graph.speed() == 0.0)
    assert seconds_from_stamp(graph.commands[-1].header.stamp) <= begun + LIMIT + ONE_POSE
    graph.until(lambda: f"pose refused: {reason}" in graph.states[-1].message)
    graph.simulator.set_parameters([Parameter("simulator.mocap_fault", value="none")])
    graph.until(lambda: graph.speed() > 0.3)
