"""mocap_node alone, with a fake motion capture."""

import math
import sys
import time

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
from collplan_ros.messages.cloud_reading import impact_from_cloud
from collplan_ros.messages.conversions import pose_to_message
from collplan_ros.messages.qos import EVENT, POSE_PUBLISHED, POSE_SUBSCRIBED
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.reading import seconds_from_stamp
from collplan_ros.nodes.mocap_node import MocapNode
from node_health import NodeHealth

CREEP = (1e-3, 0.0)
"""Velocity almost at rest, at which no pose repeats the last one [m/s]."""


class MocapBench:
    """The node, a motion capture that feeds it, and everything it says."""

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


def test_a_hit_is_published_once(ros, bench):
    bench.drive(5.0, 25, (0.0, 0.0), (1.0, 0.2))
    bench.drive(5.25, 25, (0.25, 0.05), (-0.7, 0.2))
    assert ros.wait_until(lambda: bench.impacts and bench.contacts)
    ros.spin(0.05)
    assert len(bench.impacts) == len(bench.contacts) == 1
    change = bench.impacts[0]
    assert change.header.frame_id == "map"
    assert (change.vector.x, change.vector.y) == pytest.approx((-1.7, 0.0), abs=0.1)
    contact = impact_from_cloud(bench.contacts[0], "map")
    assert contact.time == pytest.approx(5.25, abs=0.002)
    assert contact.time < seconds_from_stamp(change.header.stamp) - 0.005
    np.testing.assert_allclose(contact.point, [0.34, 0.05], atol=0.005)
    np.testing.assert_allclose(contact.normal, [-1.0, 0.0], atol=0.05)


AT_ZERO = {"position.x": 0.0, "position.y": 0.0, "orientation.w": 0.0, "orientation.z": 0.0}
BROKEN = (
    ("not_finite", {"position.x": math.nan}),
    ("zeros", AT_ZERO),
    ("quaternion", {"orientation.w": 0.5}),
    ("leap", {"position.x": 3.0}),
    ("yaw", {"orientation.z": 1.0, "orientation.w": 0.0}),
    ("tilt", {"orientation.x": math.sin(0.2), "orientation.w": math.cos(0.2)}),
    ("height", {"position.z": 0.2}),
)


def test_what_is_no_pose_goes_nowhere_and_is_said_with_its_reason(ros, bench):
    bench.drive(5.0, 10, (0.1, 0.1), CREEP)
    assert ros.wait_until(lambda: len(bench.odometry) == 4)
    for _, fields in BROKEN:
        message = pose_to_message(PoseSample(5.2, np.array([0.1, 0.1]), 0.0), "map")
        for path, value in fields.items():
            part, name = path.split(".")
            setattr(getattr(message.pose, part), name, value)
        bench.send(message)
    bench.send_at(5.1, 0.1, 0.1, "odom")
    bench.send_at(5.05, 0.1, 0.1)
    reasons = [*(reason for reason, _ in BROKEN), "frame", "stamp"]
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


def test_poses_get_even_stamps_where_the_rate_of_the_cameras_is_told(ros):
    bench = MocapBench(ros, {"mocap.rate": 100.0})
    for k in range(40):
        bench.send_at(0.0, 0.005 * k, 0.1)
    assert ros.wait_until(lambda: len(bench.odometry) > 25)
    stamps = [seconds_from_stamp(message.header.stamp) for message in bench.odometry]
    assert min(np.diff(stamps)) > 0.0, stamps
    assert not bench.refusals


def test_stamps_in_another_unit_are_named(ros, bench):
    began = time.monotonic()
    assert ros.wait_until(
        lambda: bench.send_at(5.0 + 1e-3 * (t := time.monotonic() - began), 1e-4 * t, 0.1) or bench.refusals
    )
    assert bench.refusals[0].data.startswith("clock: ")
    assert "of stamps in" in bench.refusals[0].data
    assert bench.health.says("header.stamp")


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
