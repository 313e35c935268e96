"""mocap_node alone, with a fake motion capture."""

import math
import sys

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

from collplan_core.parameters.spec import ParameterError
from collplan_core.poses.pose_filter import PoseSample
from collplan_ros.messages.conversions import pose_to_message
from collplan_ros.messages.qos import EVENT, POSE_PUBLISHED, POSE_SUBSCRIBED
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.nodes.mocap_node import MocapNode
from node_health import NodeHealth

CREEP = (1e-3, 0.0)
"""Velocity almost at rest, at which no pose repeats the last one [m/s]."""


class MocapBench:
    def __init__(self, ros, parameters=None):
        self.ros = ros
        self.odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
        self.refusals = ros.listen(String, "mocap/refused", POSE_SUBSCRIBED)
        self.impacts = ros.listen(Vector3Stamped, "impact", EVENT)
        self.contacts = ros.listen(PointCloud2, "impact/contact", EVENT)
        self.health = NodeHealth(ros, "/mocap_node")
        self.node = ros.make(MocapNode, parameters)
        self.poses = ros.publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
        assert ros.wait_until(lambda: self.node.count_subscribers("mocap/odom") and self.health.reports)

    def send(self, message):
        self.poses.publish(message)
        self.ros.spin(0.002)

    def send_at(self, stamp, x, y, frame="map"):
        self.send(pose_to_message(PoseSample(stamp, np.array([x, y]), 0.3), frame))

    def drive(self, begin, n, start, velocity):
        """n poses at 100 Hz along a straight line."""
        for k in range(n):
            self.send_at(begin + 0.01 * k, *(np.array(start) + 0.01 * k * np.array(velocity)))


@pytest.fixture
def bench(ros):
    return MocapBench(ros)


def test_poses_become_odometry(ros, bench):
    first = bench.health.newest
    assert (first.level, "/mocap/pose" in first.message) == (DiagnosticStatus.ERROR, True)
    bench.drive(5.0, 20, (0.5, 1.0), (0.8, -0.4))
    assert ros.wait_until(lambda: len(bench.odometry) == 14)
    state = state_from_bytes(serialize_message(bench.odometry[-1]), "map", "base_link")
    np.testing.assert_allclose(state.position, [0.652, 0.924], atol=1e-9)
    np.testing.assert_allclose(state.velocity, [0.8, -0.4], atol=1e-6)
    assert (state.yaw, state.stamp) == pytest.approx((0.3, 5.19), abs=1e-9)
    assert not bench.impacts


def test_what_is_no_pose_goes_nowhere_and_is_said_with_its_reason(ros, bench):
    bench.drive(5.0, 10, (0.1, 0.1), CREEP)
    assert ros.wait_until(lambda: len(bench.odometry) == 4)
    bench.send_at(5.2, math.nan, 0.1)
    bench.send_at(5.1, 0.1, 0.1, "odom")
    bench.send_at(5.05, 0.1, 0.1)
    reasons = ["not_finite", "frame", "stamp"]
    assert ros.wait_until(lambda: len(bench.refusals) == len(reasons))
    assert [message.data.split(":")[0] for message in bench.refusals] == reasons
    assert len(bench.odometry) == 4
    assert bench.health.counts("refused", len(reasons))
    assert bench.health.count("refused_not_finite") == 1


def test_poses_that_come_too_far_apart_are_named(ros, bench):
    stamps = (5.0 + 0.2 * k for k in range(10_000))
    assert ros.wait_until(lambda: bench.send_at((t := next(stamps)), 1e-4 * t, 0.1) or is_apart(bench))
    assert not bench.odometry
    bench.drive(9000.0, 10, (0.1, 0.1), CREEP)
    assert ros.wait_until(lambda: bench.odometry and not is_apart(bench))


def is_apart(bench) -> bool:
    return "0.20 s apart" in bench.health.newest.message


def test_frames_are_parameters(ros):
    bench = MocapBench(ros, {"frames.map": "lab", "frames.base": "puck", "mocap.accept_frozen": True})
    for k in range(10):
        bench.send_at(1.0 + 0.01 * k, 0.0, 0.0, "lab")
    assert ros.wait_until(lambda: bench.odometry)
    assert (bench.odometry[0].header.frame_id, bench.odometry[0].child_frame_id) == ("lab", "puck")


def test_transform_without_tf2_msgs_is_an_error_that_says_so(ros, monkeypatch):
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", None)
    with pytest.raises(ParameterError, match=r"mocap\.publish_tf.*tf2_msgs"):
        ros.make(MocapNode, {"mocap.publish_tf": True})


def test_an_odometry_that_stands_repeats_itself(ros):
    odometry, refusals = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED), ros.listen(String, "mocap/refused", 10)
    ros.make(MocapNode, {"mocap.format": "odometry", "mocap.topic": "odom"})
    wheels = ros.publisher(Odometry, "odom", POSE_PUBLISHED)
    message = Odometry()
    message.header.frame_id, message.pose.pose.orientation.w = "map", 1.0
    for k in range(40):
        message.header.stamp.sec, message.header.stamp.nanosec = 5, 10_000_000 * k
        wheels.publish(message)
        ros.spin(0.005)
    assert ros.wait_until(lambda: len(odometry) == 34)
    assert not refusals
