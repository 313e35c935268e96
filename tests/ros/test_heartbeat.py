"""The planner's heartbeat, as the controller watches it."""

from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import Empty

from collplan_core.parameters import Limits
from collplan_ros.messages.qos import LATCHED, NEWEST
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.heartbeat import PERIOD
from collplan_ros.nodes.planner_node import PlannerNode
from fake_robot import FakeRobot, hall


def test_after_a_heartbeat_its_silence_stops_until_it_comes_again_and_without_one_it_is_not_missed(ros):
    FakeRobot(ros, hall())
    states = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
    ros.make(ControllerNode)
    beat = ros.publisher(Empty, "planner/heartbeat", NEWEST)
    ros.spin(2 * Limits().heartbeat_age)
    assert not any("heartbeat" in state.message for state in states)
    beat.publish(Empty())
    assert ros.wait_until(lambda: "planner heartbeat" in states[-1].message)
    assert f"limit {Limits().heartbeat_age:.2f} s" in states[-1].message
    ros.probe.create_timer(PERIOD, lambda: beat.publish(Empty()))
    assert ros.wait_until(lambda: "heartbeat" not in states[-1].message)


def test_the_planner_beats_while_its_executor_does_not_run(ros):
    beats = ros.listen(Empty, "planner/heartbeat", 100)
    planner = ros.make(PlannerNode)
    assert ros.wait_until(lambda: beats)
    ros.hold(planner)
    before = len(beats)
    assert ros.wait_until(lambda: len(beats) > before + 5)
