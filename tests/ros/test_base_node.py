"""base_node alone: between cmd_vel and a base that takes velocities, and nothing else."""

import math

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Log
from std_srvs.srv import Trigger

from collplan_core.parameters.spec import ParameterError
from collplan_core.state import State
from collplan_ros.messages.conversions import state_to_odometry
from collplan_ros.messages.qos import LATCHED, NEWEST, POSE_PUBLISHED
from collplan_ros.messages.reading import twist_of
from collplan_ros.node_kit.clock import seconds, steady_clock
from collplan_ros.nodes.base_node import BaseNode
from node_health import NodeHealth

TOPIC = "/base/cmd_vel"


class BaseBench:
    def __init__(self, ros, listens=True, **parameters):
        self.ros = ros
        kind = TwistStamped if parameters.get("base.stamped") else Twist
        self.taken = ros.listen(kind, TOPIC) if listens else []
        self.states = ros.listen(DiagnosticStatus, "robot/state", LATCHED)
        self.health = NodeHealth(ros, "/base_node")
        self.node = ros.make(BaseNode, {"base.topic": TOPIC, **parameters})
        self.commands = ros.publisher(Twist, "cmd_vel", NEWEST)
        self.poses = ros.publisher(Odometry, "mocap/odom", POSE_PUBLISHED)
        self.velocity, self.x = None, 0.0
        ros.probe.create_timer(0.05, self._command)

    def _command(self):
        if self.velocity is not None:
            twist = Twist()
            twist.linear.x, twist.linear.y = self.velocity
            self.commands.publish(twist)

    @property
    def state(self):
        return self.states[-1].message if self.states else ""

    @property
    def speed(self):
        linear = twist_of(self.taken[-1]).linear
        return math.hypot(linear.x, linear.y)

    def until(self, condition):
        assert self.ros.wait_until(condition, 30.0), self.state

    def go(self):
        self.velocity = (0.4, 0.2)
        self.until(lambda: self.ros.call(Trigger, "resume").success)
        self.until(lambda: self.taken and self.speed > 0.4)

    def moves_at(self, speed):
        self.x += 0.02 * speed
        stamp, position = seconds(self.ros.probe.get_clock()), np.array([self.x, 0.0])
        state = State(stamp, position, np.array([speed, 0.0]), 0.0)
        self.poses.publish(state_to_odometry(state, "map", "base_link", 0.0))
        self.ros.spin(0.02)


def test_it_sends_commands_on_and_zero_whenever_it_may_not_move(ros):
    bench = BaseBench(ros, **{"base.stamped": True})
    bench.velocity = (0.4, 0.2)
    bench.until(lambda: len(bench.taken) > 10)
    assert all(not twist_of(each).linear.x for each in bench.taken), "held until somebody lets it move"
    bench.go()
    assert ros.call(Trigger, "estop").success
    sent = len(bench.taken)
    bench.until(lambda: len(bench.taken) > sent + 10)
    assert all(not twist_of(each).linear.x for each in bench.taken[sent + 2 :])
    assert ros.call(Trigger, "clear_estop").success
    bench.go()
    bench.velocity = None
    bench.until(lambda: bench.speed == 0.0)  # the last command has expired
    assert bench.taken[-1].header.frame_id == "base_link"
    assert bench.taken[-1].header.stamp.sec > 0


def test_zero_goes_on_at_the_rate_that_the_watchdog_of_a_base_needs(ros):
    bench = BaseBench(ros, **{"base.rate": 40.0})
    bench.until(lambda: bench.taken)
    clock, before = steady_clock(), len(bench.taken)
    begun = seconds(clock)
    bench.until(lambda: len(bench.taken) >= before + 40)
    assert seconds(clock) - begun > 40 / 60.0


def test_a_base_that_drives_on_after_zero_is_held_and_told(ros):
    bench = BaseBench(ros)
    bench.go()
    bench.moves_at(0.45)
    bench.velocity = (0.0, 0.0)
    bench.until(lambda: bench.speed == 0.0)
    begun = seconds(steady_clock())
    bench.until(lambda: bench.moves_at(0.45) or "drives on" in bench.state)
    # 0.45 / 1.5 to brake, three lags, and base.runaway_time
    assert seconds(steady_clock()) - begun > 0.3 + 0.3 + 0.5 - 0.1
    assert "Stop it by hand" in bench.state


def test_a_stopped_base_that_drives_on_is_told_too(ros):
    bench = BaseBench(ros)
    bench.go()
    logged = ros.listen(Log, "/rosout", 100)
    assert ros.call(Trigger, "estop").success
    bench.until(lambda: bench.moves_at(0.45) or any("drives on" in each.msg for each in logged))


def test_who_brushes_a_base_that_stands_holds_it_not(ros):
    bench = BaseBench(ros, **{"limits.pose_age": 0.5, "limits.motion_delay": 0.4})
    bench.go()
    bench.velocity = (0.0, 0.0)
    bench.until(lambda: bench.speed == 0.0)
    for poses, speed in ((100, 0.0), (10, 0.3), (80, 0.0)):
        for _ in range(poses):
            bench.moves_at(speed)
    assert "drives on" not in bench.state
    bench.velocity = (0.4, 0.2)
    bench.until(lambda: bench.speed > 0.4)


def test_its_nodes_last_word_is_zero(ros):
    bench = BaseBench(ros)
    bench.go()
    bench.node.stop()
    bench.until(lambda: bench.speed == 0.0)


def test_nobody_listens_and_somebody_else_sends(ros):
    deaf = BaseBench(ros, listens=False)
    deaf.velocity = (0.4, 0.0)
    answer = ros.call(Trigger, "resume")
    assert not answer.success
    assert TOPIC in answer.message
    deaf.taken = ros.listen(Twist, TOPIC)
    deaf.go()
    other = ros.add(rclpy.create_node("navigation", context=ros.context))
    other.create_publisher(Twist, TOPIC, NEWEST)
    deaf.until(lambda: "/navigation" in deaf.state)
    assert "held" in deaf.state
    deaf.until(lambda: deaf.speed == 0.0)


def test_refused_parameters(ros):
    for parameters, words in (
        ({"base.topic": "cmd_vel"}, "base.topic"),
        ({"base.rate": 2.0}, "base.rate: got 2, expected at least 4 Hz"),
        ({"robot.max_speed": 2.0}, "cap.speed"),
        ({"base.topic": TOPIC, "base.touch": "hit"}, "ArmorHit of robomaster_msgs is not"),
    ):
        with pytest.raises(ParameterError, match=words):
            ros.make(BaseNode, parameters)
