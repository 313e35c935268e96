"""Two publishers of what one alone may send are named; one that was started again, or is silent, is none."""

from functools import partial

import pytest
from geometry_msgs.msg import TransformStamped
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import LaserScan
from terminal import ERROR, Terminal

from collplan_ros.messages.qos import SENSOR_DATA
from collplan_ros.node_kit.publishers import Senders
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.mocap_node import MocapNode
from node_health import NodeHealth

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def counts(*runs):
    """Publishers' counts by time: (first count, begin, end, period) [s] each."""
    sent = [(begin + k * each, n + k) for n, begin, end, each in runs for k in range(round((end - begin) / each))]
    return sorted(sent, key=lambda one: one[0])


@pytest.mark.parametrize(
    ("runs", "are_two"),
    [
        ([(1, 0.0, 20.0, 0.02)], False),
        ([(1, 0.0, 20.0, 0.02), (1, 0.001, 20.0, 0.02)], True),
        ([(500, 0.0, 20.0, 0.01), (1, 0.005, 20.0, 0.5)], True),
        ([(500, 0.0, 5.0, 0.02), (1, 5.0, 20.0, 0.02)], False),
        ([(1, 0.0, 20.0, 0.02), (1, 0.001, 5.0, 0.02)], False),
    ],
    ids=["one", "equal counts", "other rates", "started again", "the second ended"],
)
def test_two_that_send_are_told_from_one_that_starts_again(runs, are_two):
    senders = Senders()
    for now, number in counts(*runs):
        senders.took(number, now)
    assert senders.are_several(20.0) == are_two


def nodes_of(ros, *names):
    return [ros.make(lambda name=name, **kwargs: Node(name, **kwargs)) for name in names]


def transforms(real_messages, child="odom"):
    kind = real_messages("tf2_msgs.msg").TFMessage
    message = kind(transforms=[TransformStamped(child_frame_id=child)])
    message.transforms[0].header.frame_id = "map"
    return kind, message


TIED = {"mocap.format": "odometry", "mocap.topic": "/odom", "mocap.frame": "odom", "mocap.localised": True}


@pytest.mark.parametrize("topic", ["/scan", "/tf", "/tf_static"])
def test_both_are_named_once_in_the_log_and_on_diagnostics_and_nothing_of_one(ros, real_messages, topic):
    terminal = Terminal(ros)
    first, second = nodes_of(ros, "receiver", "second_receiver")
    kind, message = (LaserScan, LaserScan()) if topic == "/scan" else transforms(real_messages)
    heard, qos = ("/scan", SENSOR_DATA) if topic == "/scan" else ("/tf", 100)
    node = ros.make(ControllerNode) if topic == "/scan" else ros.make(MocapNode, TIED)
    health = NodeHealth(ros, f"/{node.get_name()}")
    ros.probe.create_timer(0.02, partial(first.create_publisher(kind, heard, qos).publish, message))

    def errors():
        return [text for level, text in terminal.lines(node) if level == ERROR]

    ros.spin(2.5)
    assert not errors()
    other = second.create_publisher(kind, topic, LATCHED if topic == "/tf_static" else qos)
    other.publish(message)
    if topic != "/tf_static":
        ros.probe.create_timer(0.07, partial(other.publish, message))
    assert health.says("/second_receiver")
    assert terminal.has(node, "/receiver")
    ros.spin(2.5)
    (said,) = errors()
    words = "comes on /tf" if topic == "/tf_static" else f"2 nodes publish {topic}"
    assert all(each in said for each in (words, "/receiver", "/second_receiver"))
