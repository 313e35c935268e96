"""Every node but a planner, in a hall, with a motion capture that is late, or that turns, tips or lifts the robot."""

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.parameter import Parameter
from std_msgs.msg import Float64
from std_srvs.srv import Trigger

from collplan_core.control.motion_monitor import OK
from collplan_ros.messages.conversions import seconds_from_stamp
from collplan_ros.messages.qos import LATCHED
from fake_robot import hall
from foreign_planner import ForeignPlanner
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
        ros.make(ForeignPlanner, CLOCK, goal=hall().goal)
        return graph

    return made


def test_late_poses_stop_the_robot_and_the_delay_is_published(make_hall):
    graph = make_hall(mocap_latency=0.3)
    graph.until(lambda: "motion comes after its command by 0." in graph.said)
    assert graph.states[-1].level == DiagnosticStatus.WARN
    graph.until(lambda: graph.speed == 0.0)


def test_a_robot_in_time_drives_and_its_delay_is_published(make_hall):
    graph = make_hall()
    graph.until(lambda: graph.poses[-1].pose.position.x > 1.5)
    assert graph.delays
    assert graph.delays[-1].data < 0.1
    assert not graph.controller._loop.held


def test_a_robot_in_its_emergency_stop_is_commanded_zero_and_neither_stuck_nor_reversed(make_hall):
    graph = make_hall()
    graph.until(lambda: graph.poses[-1].pose.position.x > 0.5 and graph.speed > 0.3)
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
    assert graph.speed == 0.0
    assert graph.states[-1].message.startswith("stands still: held: emergency stop by its service")


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
