"""mocap_node between an odometry and a localisation, with the real messages of /tf."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, Vector3Stamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError
from collplan_core.poses.pose_filter import PoseSample
from collplan_ros.messages.conversions import pose_to_message, quaternion_from_yaw
from collplan_ros.messages.qos import EVENT, POSE_PUBLISHED, POSE_SUBSCRIBED
from collplan_ros.nodes import localisation, odometry_body
from collplan_ros.nodes.mocap_node import MocapNode
from node_health import NodeHealth

USED = {"mocap.format": "odometry", "mocap.topic": "/odom", "mocap.frame": "odom", "mocap.localised": True}
QUARTER = math.pi / 2
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class OdometryBench:
    """The node, an odometry at 50 Hz and a localisation, which repeats itself on /tf."""

    def __init__(self, ros, real_messages, topic="/tf", **parameters):
        self.ros = ros
        self.kind = real_messages("tf2_msgs.msg").TFMessage
        self.odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
        self.refusals = ros.listen(String, "mocap/refused", POSE_SUBSCRIBED)
        self.impacts = ros.listen(Vector3Stamped, "impact", EVENT)
        self.node = ros.make(MocapNode, USED | parameters)
        self.transforms = ros.publisher(self.kind, topic, 100 if topic == "/tf" else LATCHED)
        self.tied = None
        ros.probe.create_timer(0.05, self._repeat)
        self.poses = ros.publisher(Odometry, "/odom", POSE_PUBLISHED)
        assert ros.wait_until(lambda: self.node.count_subscribers("mocap/odom"))
        self.stamp, self.x, self.body = 5.0, 0.0, "base_link"

    def ties(self, x: float, y: float, yaw: float) -> None:
        transform = TransformStamped(child_frame_id="odom")
        transform.header.frame_id = "map"
        transform.transform.translation.x, transform.transform.translation.y = x, y
        transform.transform.rotation = quaternion_from_yaw(yaw)
        other = TransformStamped(child_frame_id="laser")
        other.header.frame_id = "base_link"
        self.tied = self.kind(transforms=[other, transform])
        self.transforms.publish(self.tied)
        self.ros.spin(0.05)

    def _repeat(self) -> None:
        if self.tied is not None and self.transforms.topic_name == "/tf":
            self.transforms.publish(self.tied)

    def drive(self, n: int, speed: float) -> None:
        for _ in range(n):
            self.drive_one(speed)
            self.ros.spin(0.005)

    def drive_one(self, speed: float = 0.0) -> None:
        self.stamp, self.x = self.stamp + 0.02, self.x + 0.02 * speed
        pose = pose_to_message(PoseSample(self.stamp, np.array([self.x, 0.0]), 0.0), "odom")
        message = Odometry(header=pose.header, child_frame_id=self.body)
        message.pose.pose = pose.pose
        self.poses.publish(message)

    @property
    def place(self) -> tuple[float, float]:
        position = self.odometry[-1].pose.pose.position
        return position.x, position.y


def test_poses_are_those_of_the_map_from_the_first_transform_on(ros, real_messages):
    bench = OdometryBench(ros, real_messages)
    bench.drive(10, 0.5)
    assert ros.wait_until(lambda: bench.refusals)
    assert "no transform from map to odom" in bench.refusals[-1].data
    assert not bench.odometry
    bench.ties(1.0, 2.0, QUARTER)
    bench.drive(20, 0.5)
    assert ros.wait_until(lambda: bench.odometry and bench.place == pytest.approx((1.0, 2.0 + bench.x)))
    twist = bench.odometry[-1].twist.twist.linear  # in the body frame, which has turned with it
    assert (twist.x, twist.y) == pytest.approx((0.5, 0.0), abs=1e-6)


@pytest.mark.parametrize(("topic", "is_used"), [("/tf", False), ("/tf_static", True)])
def test_a_transform_that_comes_no_more_is_named_unless_it_is_static(ros, real_messages, monkeypatch, topic, is_used):
    monkeypatch.setattr(localisation, "LONGEST_SILENCE", 0.3)
    bench = OdometryBench(ros, real_messages, topic)
    bench.ties(1.0, 2.0, QUARTER)
    bench.drive(20, 0.5)
    assert ros.wait_until(lambda: bench.odometry)
    assert not bench.refusals
    bench.tied = None
    ros.spin(0.4)
    bench.drive(10, 0.5)
    if is_used:
        assert ros.wait_until(lambda: bench.place == pytest.approx((1.0, 2.0 + bench.x)))
        return
    assert ros.wait_until(lambda: bench.refusals)
    assert "no transform from map to odom on /tf for 0." in bench.refusals[-1].data


def test_a_correction_is_neither_a_leap_nor_an_impact_and_a_jump_of_a_metre_is(ros, real_messages):
    bench = OdometryBench(ros, real_messages)
    bench.ties(1.0, 2.0, 0.0)
    bench.drive(20, 0.5)
    ros.wait_until(lambda: bench.odometry)
    bench.ties(1.03, 1.98, 0.01)
    heard = len(bench.odometry)
    bench.drive(20, 0.5)
    assert ros.wait_until(lambda: len(bench.odometry) == heard + 20)
    speeds = [each.twist.twist.linear.x for each in bench.odometry[heard:]]
    assert speeds == pytest.approx([0.5] * 20, abs=1e-6)
    assert not bench.impacts
    assert not bench.refusals
    bench.ties(2.03, 1.98, 0.01)
    bench.drive(5, 0.5)
    assert ros.wait_until(lambda: bench.refusals)
    assert bench.refusals[-1].data.startswith("kidnapped: the localisation moved it by 1.00 m")


def test_odometry_is_not_believed_while_it_slips(ros, real_messages):
    bench = OdometryBench(ros, real_messages, **{"mocap.slip_time": 0.1})
    bench.ties(0.0, 0.0, 0.0)
    bench.drive(25, 1.0)
    assert ros.wait_until(lambda: bench.odometry)
    bench.drive(25, -0.6)
    assert ros.wait_until(lambda: bench.impacts)
    ros.spin(0.1)
    stamps = [each.header.stamp.sec + 1e-9 * each.header.stamp.nanosec for each in bench.odometry]
    assert 0.1 <= max(np.diff(stamps)) <= 0.14


def test_poses_of_a_localisation_alone_are_refused_with_what_to_set_up(ros):
    health = NodeHealth(ros, "/mocap_node")
    ros.make(MocapNode, {"mocap.format": "pose_with_covariance", "mocap.topic": "/amcl_pose"})
    poses = ros.publisher(PoseWithCovarianceStamped, "/amcl_pose", POSE_PUBLISHED)
    for k in range(9):
        pose = pose_to_message(PoseSample(5.0 + 0.33 * k, np.array([0.01 * k, 0.0]), 0.0), "map")
        message = PoseWithCovarianceStamped(header=pose.header)
        message.pose.pose = pose.pose
        poses.publish(message)
        ros.spin(0.33)
    assert any("mocap.format odometry, mocap.localised" in each.status[0].message for each in health.reports)


def test_refused_parameters(ros):
    for parameters, words in (({"mocap.frame": ""}, "mocap.frame"), ({"mocap.slip_time": 0.2}, "slip_time: got 0.2")):
        with pytest.raises(ParameterError, match=words):
            ros.make(MocapNode, USED | parameters)


def joining(parent: str, child: str, ahead: float) -> TransformStamped:
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id, transform.transform.translation.x = parent, ahead
    transform.transform.rotation.w = 1.0
    return transform


def test_an_odometry_of_another_body_is_named_with_its_place(real_messages):
    kind = real_messages("tf2_msgs.msg").TFMessage
    for body, joined, words in (
        ("camera", ("base_link", "camera", 0.2), "got 'camera', expected 'base_link'.*mocap.body_offset_x 0.200"),
        ("camera", None, "nothing on /tf_static joins them"),
        ("base_footprint", ("base_footprint", "base_link", 0.0), ""),
        ("", None, ""),
    ):
        now, listening = [0.0], []
        node = SimpleNamespace(create_subscription=lambda _, topic, take, qos, to=listening: to.append(take))
        known = odometry_body.OdometryBody(node, lambda now=now: now[0])
        listening[0](kind(transforms=[joining(*joined)] if joined else []))
        assert known.why_another(body, Settings()) == ""  # a transform may be on its way
        now[0] = odometry_body.PATIENCE
        why = known.why_another(body, Settings())
        assert bool(why) == bool(words), body
        assert re.search(words, why), why


def test_a_node_says_so_on_diagnostics(ros, real_messages, monkeypatch):
    monkeypatch.setattr(odometry_body, "PATIENCE", 0.3)
    health = NodeHealth(ros, "/mocap_node")
    bench = OdometryBench(ros, real_messages)
    transform = joining("base_link", "camera", 0.2)
    ros.publisher(bench.kind, "/tf_static", LATCHED).publish(bench.kind(transforms=[transform]))
    bench.body = "camera"
    bench.ties(0.0, 0.0, 0.0)
    ros.probe.create_timer(0.05, bench.drive_one)
    assert ros.wait_until(lambda: "mocap.body_offset_x 0.200" in health.newest.message)
