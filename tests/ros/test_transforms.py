"""Poses on /tf, over DDS: those that mocap_node broadcasts, and those that it reads where others broadcast too."""

from importlib.resources import files

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from collplan_core.parameters import Settings
from collplan_core.poses.pose_filter import PoseSample
from collplan_ros.messages.conversions import header, pose_to_message
from collplan_ros.messages.mocap_formats import FORMATS
from collplan_ros.messages.qos import EVERY_LATCHED, EVERY_ONE, POSE_PUBLISHED, POSE_SUBSCRIBED
from collplan_ros.nodes.mocap_node import MocapNode
from collplan_ros.run.schemas import schema_text
from collplan_ros.run.topics import recorded_topics

AS_TF2_ROS = QoSProfile(depth=100)
SET = str(files("collplan_ros") / "config" / "mocap_tf.yaml")


@pytest.fixture
def transforms(real_messages):
    return real_messages("tf2_msgs.msg").TFMessage


def poses_along_x(frame: str, count: int = 20):
    """Poses at 100 Hz of a body that drives at 0.8 m/s."""
    for k in range(count):
        yield pose_to_message(PoseSample(5.0 + 0.01 * k, np.array([0.5 + 0.008 * k, 1.0]), 0.3), frame)


def transform_of(pose: PoseStamped, child: str) -> TransformStamped:
    message = TransformStamped(header=pose.header, child_frame_id=child)
    message.transform.translation.x, message.transform.translation.y = pose.pose.position.x, pose.pose.position.y
    message.transform.rotation = pose.pose.orientation
    return message


def test_every_pose_is_broadcast_as_tf2_ros_does(ros, transforms):
    broadcast, odometry = ros.listen(transforms, "/tf", AS_TF2_ROS), ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    node = ros.make(MocapNode, {"mocap.publish_tf": True})
    (publisher,) = [each for each in node.publishers if each.topic_name == "/tf"]
    qos = publisher.qos_profile
    assert (qos.depth, qos.reliability, qos.durability) == (100, ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE)
    assert ros.wait_until(lambda: publisher.get_subscription_count() and node.count_subscribers("mocap/odom"))
    poses = ros.publisher(PoseStamped, "mocap/pose", POSE_PUBLISHED)
    for pose in poses_along_x("map"):
        poses.publish(pose)
        ros.spin(0.002)
    assert ros.wait_until(lambda: len(broadcast) == len(odometry) == 14)
    for message, pose in zip(broadcast, odometry, strict=True):
        assert FORMATS["tf"].read(message, "base_link") == FORMATS["odometry"].read(pose, "")


def test_the_shipped_set_reads_the_body_among_others(ros, transforms):
    odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    ros.make(MocapNode, cli_args=["--ros-args", "--params-file", SET])
    broadcaster = ros.publisher(transforms, "/tf", AS_TF2_ROS)
    arm = TransformStamped(header=header(9.0, "odom"), child_frame_id="arm")
    for pose in poses_along_x("world"):
        broadcaster.publish(transforms(transforms=[arm, transform_of(pose, "omnipuck")]))
        broadcaster.publish(transforms(transforms=[arm]))
        ros.spin(0.002)
    assert ros.wait_until(lambda: len(odometry) == 14)
    newest = odometry[-1].pose.pose.position
    assert (newest.x, newest.y) == pytest.approx((0.652, 1.0), abs=1e-9)


def test_what_is_broadcast_is_recorded_with_its_definition(transforms):
    recorded = recorded_topics(Settings())
    assert (recorded["/tf"].kind, recorded["/tf"].qos) == (transforms, EVERY_ONE)
    assert (recorded["/tf_static"].kind, recorded["/tf_static"].qos) == (transforms, EVERY_LATCHED)
    # not the text that another test may have found where the package is not
    assert "MSG: geometry_msgs/TransformStamped" in schema_text.__wrapped__("tf2_msgs/msg/TFMessage")
