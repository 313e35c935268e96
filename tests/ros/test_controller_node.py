"""What controller_node hears and publishes, with a fake robot that stands in a hall and a fake planner."""

import math
import uuid
from dataclasses import replace

import numpy as np
import pytest
import rclpy
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import PointStamped, Twist
from nav_msgs.msg import Path
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Empty, String
from terminal import Terminal

from collplan_core.goal import Goal
from collplan_core.parameters import Limits
from collplan_core.plan import Candidates, Contacts, Plan
from collplan_ros.messages.conversions import stamp_from_seconds
from collplan_ros.messages.planner_clouds import plan_to_message
from collplan_ros.messages.qos import CONSTANTS_PUBLISHED, EVENT, LATCHED, NEWEST
from collplan_ros.messages.raw_reading import plan_to_path
from collplan_ros.messages.reading import GOAL_STATUS
from collplan_ros.messages.states import goal_to_status
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.heartbeat import BEAT_PERIOD
from fake_robot import FakeRobot, hall
from node_health import NodeHealth

YAW = 0.7
SPEED = 0.5


def straight_plan(stamp: float, start: np.ndarray, duration: float = 2.0) -> Plan:
    times = stamp + np.linspace(0.0, duration, 21)
    positions = start + np.column_stack([SPEED * (times - stamp), np.zeros(21)])
    nothing = Candidates(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    velocities = np.tile([SPEED, 0.0], (21, 1))
    return Plan(stamp, times, positions, velocities, Contacts.none(), positions[-1], velocities[-1], {}, nothing, 0)


class Bench:
    def __init__(self, ros):
        self.ros = ros
        self.commands = ros.listen(Twist, "cmd_vel", EVENT)
        self.references = ros.listen(PointStamped, "controller/reference", EVENT)
        self.maneuvers = ros.listen(String, "maneuver", LATCHED)
        self.states = ros.listen(DiagnosticStatus, "controller/state", LATCHED)
        self.health = NodeHealth(ros, "/controller_node")
        self.robot = FakeRobot(ros, hall(), YAW)
        # all share a thread here, and poses wait in its queues
        self.node = ros.make(ControllerNode, {"limits.motion_delay": 0.4})
        self._plans = ros.publisher(Path, "plan", NEWEST)
        self._statuses = ros.publisher(GoalStatus, "goal_status", LATCHED)
        self.plans_on = False
        ros.probe.create_timer(0.05, lambda: self.plans_on and self._plans.publish(self.path()))

    def give_goal(self, status=GoalStatus.STATUS_EXECUTING):
        goal = Goal(uuid.uuid4().bytes, self.robot.stamp, np.full(2, math.nan), GOAL_STATUS[status])
        self._statuses.publish(goal_to_status(goal))

    def path(self) -> Path:
        return deserialize_message(plan_to_path(straight_plan(self.robot.stamp, self.robot.position), "map"), Path)

    def publish(self, message_type, topic, message, qos=EVENT):
        publisher = self.ros.publisher(message_type, topic, qos)
        publisher.publish(message)
        return publisher

    def drive(self):
        self.give_goal()
        self.plans_on = True
        assert self.ros.wait_until(self.moves), self.states

    def moves(self):
        return bool(self.commands) and is_moving(self.commands[-1])

    def stands(self, reason):
        return self.ros.wait_until(lambda: not self.moves() and reason in self.states[-1].message)


def is_moving(twist) -> bool:
    return twist.linear.x != 0.0 or twist.linear.y != 0.0 or twist.angular.z != 0.0


@pytest.fixture
def bench(ros):
    return Bench(ros)


def test_follows_a_plan_in_the_robot_frame_from_rest_until_the_goal_ends(ros, bench):
    assert ros.wait_until(lambda: len(bench.commands) > 3 and bench.states)
    assert bench.states[-1].level == DiagnosticStatus.OK
    bench.drive()
    assert not is_moving(bench.commands[0])
    assert ros.wait_until(lambda: bench.references and bench.maneuvers[-1].data == "free_space")
    first = next(c for c in bench.commands if is_moving(c))
    assert 0.8 * SPEED < math.hypot(first.linear.x, first.linear.y) <= 1.2
    assert math.atan2(first.linear.y, first.linear.x) == pytest.approx(-YAW, abs=0.05)
    reference = bench.references[0]
    assert reference.header.frame_id == "map"
    assert 0.0 <= reference.point.x <= 2.0 * SPEED
    assert reference.point.y == pytest.approx(0.0, abs=1e-9)
    assert bench.health.counts("control_period_ms.n", 5)
    assert float(bench.health.value("control_period_ms.p50")) > 0.0
    bench.give_goal(GoalStatus.STATUS_CANCELED)
    assert bench.stands("no active goal")
    assert (bench.states[-1].level, bench.maneuvers[-1].data) == (DiagnosticStatus.OK, "stopped")
    assert bench.health.says("no active goal", DiagnosticStatus.OK)


def test_a_trajectory_is_followed_before_the_path_of_its_stamp_which_may_be_lost(ros, bench):
    bench.drive()
    bench.plans_on = False
    stamp = bench.robot.stamp
    plan = replace(straight_plan(stamp, bench.robot.position, 60.0), valid_until=stamp + 60.0)
    trajectory = plan_to_message(plan, "map")
    bench.publish(PointCloud2, "planner/trajectory", trajectory)
    ros.spin(0.1)
    bench.publish(Path, "plan", plan_to_path(plan, "map"), NEWEST)
    ros.spin(1.5)  # more than limits.plan_age
    assert ros.wait_until(bench.moves), bench.states
    # its last word, with no other command under way
    ros.hold(bench.node)
    ros.spin(0.1)
    bench.node.stop()
    last = len(bench.commands)
    assert ros.wait_until(lambda: len(bench.commands) > last)
    assert not is_moving(bench.commands[last])


def test_what_cannot_be_used_is_counted_by_kind_and_never_moves_the_robot(ros, bench):
    assert ros.wait_until(lambda: bench.robot.stamp > 100.2)
    bench.give_goal()
    plans = ros.publisher(Path, "plan", NEWEST)
    empty, of_another_goal = bench.path(), bench.path()
    empty.poses.clear()
    of_another_goal.header.stamp = stamp_from_seconds(50.0)
    for path in (empty, of_another_goal):
        plans.publish(path)
        ros.spin(0.1)
    bench.robot.send_bad()
    assert bench.health.refuses(plan=2, pose=3, scan=6), bench.health.newest
    assert not any(map(is_moving, bench.commands))


def test_stands_still_where_constants_differ_which_a_goal_makes_a_warning_and_plans_without_one_are_no_news(ros):
    terminal, bench = Terminal(ros), Bench(ros)
    values = [KeyValue(key="robot.radius", value="0.15")]
    other = DiagnosticStatus(name="/driver_node", message="another hash", values=values)
    bench.publish(DiagnosticStatus, "shared_constants", other, CONSTANTS_PUBLISHED)
    reason = "robot.radius: 0.09 here, 0.15 in /driver_node"
    assert ros.wait_until(lambda: bench.states and reason in bench.states[-1].message)
    assert bench.states[-1].level == DiagnosticStatus.OK
    bench.plans_on = True
    heard = len(bench.commands)
    assert ros.wait_until(lambda: len(bench.commands) > heard + 20)
    assert not [text for _, text in terminal.lines(bench.node) if "plan refused" in text]
    bench.give_goal()
    assert ros.wait_until(lambda: bench.states[-1].level == DiagnosticStatus.WARN)
    assert reason in bench.states[-1].message
    assert bench.health.says(reason, DiagnosticStatus.WARN)
    assert not any(map(is_moving, bench.commands))


def test_after_a_heartbeat_its_silence_stops_until_it_comes_again_and_without_one_it_is_not_missed(ros, bench):
    bench.drive()
    ros.spin(2 * Limits().heartbeat_age)
    assert not any("heartbeat" in state.message for state in bench.states)
    beat = bench.publish(Empty, "planner/heartbeat", Empty(), NEWEST)
    assert bench.stands(f"limit {Limits().heartbeat_age:.2f} s")
    ros.probe.create_timer(BEAT_PERIOD, lambda: beat.publish(Empty()))
    assert ros.wait_until(lambda: "heartbeat" not in bench.states[-1].message)


def test_two_hands_stop_the_robot_and_are_named(ros, bench):
    hand, sent = ros.publisher(Twist, "hand/cmd_vel", NEWEST), Twist()
    sent.linear.y = 0.2
    ros.probe.create_timer(0.02, lambda: hand.publish(sent))
    assert ros.wait_until(bench.moves)
    assert bench.health.says("by hand", DiagnosticStatus.OK)
    other = ros.add(rclpy.create_node("other_hand", context=ros.context))
    other.create_publisher(Twist, "hand/cmd_vel", NEWEST)
    assert ros.wait_until(lambda: not bench.moves())
    assert bench.health.says("/other_hand, /probe", DiagnosticStatus.WARN)
    ros.remove(other)
    assert ros.wait_until(bench.moves)
