"""A graph is subscribed to once, as bytes: what is recorded of it is what was sent, and who listens gets it too."""

import time

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosReliability
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Empty, String

from collplan_core.clock_steps import SendTimes
from collplan_core.parameters import Settings
from collplan_ros.messages import qos
from collplan_ros.run.graph_topics import GraphTopics, PollingNode
from collplan_ros.run.reader import raw_messages
from collplan_ros.run.topics import recorded_topics
from collplan_ros.run.writer import RECORDING, RecordingFile

TOPICS = recorded_topics(Settings())
SENT = {
    "mocap/odom": (Odometry(child_frame_id="base_link"), qos.POSE_PUBLISHED),
    "mocap/pose": (PoseStamped(), qos.POSE_PUBLISHED),
    "scan": (LaserScan(angle_min=-3.0), qos.SENSOR_PUBLISHED),
    "maneuver": (String(data="flow_through"), qos.LATCHED),
    "planner/heartbeat": (Empty(), qos.NEWEST),
    "plan": (Path(), qos.NEWEST),
    "/diagnostics": (DiagnosticArray(status=[DiagnosticStatus(level=b"\1")]), qos.LATCHED),
}
"""A message of each topic, and how it is published."""


class Recorded:
    def __init__(self, ros, tmp_path, topics=TOPICS, namespace="/robot1") -> None:
        self.path = tmp_path / RECORDING
        self.node = ros.add(PollingNode("recorder", context=ros.context, namespace=namespace))
        self.file = RecordingFile(self.path)
        self.times = SendTimes()
        self.topics = GraphTopics(self.node, topics, self.times, self.file)
        self._ros = ros

    def taken(self, condition, timeout: float = 10.0) -> bool:
        def holds():
            self.topics.take()
            return condition()

        return self._ros.wait_until(holds, timeout)


@pytest.fixture
def publishers(ros):
    node = ros.add(Node("sender", context=ros.context, namespace="/robot1"))

    def made(matched: bool = True):
        found = {name: node.create_publisher(type(m), name, how) for name, (m, how) in SENT.items()}
        every = found.values()
        assert not matched or ros.wait_until(lambda: all(each.get_subscription_count() for each in every))
        return found

    return made


def test_what_was_sent_is_recorded_with_its_qos_and_handed_to_who_listens(ros, tmp_path, publishers):
    recorded = Recorded(ros, tmp_path)
    heard = {name: [] for name in SENT}
    for name, taken in heard.items():
        recorded.topics.listen(name, lambda message, sent, taken=taken: taken.append((message, sent)))
    for name, publisher in publishers().items():
        publisher.publish(SENT[name][0])
    assert recorded.taken(lambda: all(heard.values()))
    assert {name: message for name, ((message, _),) in heard.items()} == {name: m for name, (m, _) in SENT.items()}
    # one subscription for file and listener
    assert all(ros.probe.count_subscribers(recorded.node.resolve_topic_name(name)) == 1 for name in SENT)
    recorded.file.finish()
    full_names = {name: recorded.node.resolve_topic_name(name) for name in SENT}
    for name, full in full_names.items():
        (raw,) = raw_messages(recorded.path, [full])
        message, sent = deserialize_message(raw.data, type(SENT[name][0])), heard[name][0][1]
        assert message == SENT[name][0]
        assert (raw.sent - recorded.times.ahead_at_first) / 1e9 == sent
        assert raw.sent <= raw.came
        assert raw.number == 1
    with AnyReader([recorded.path]) as reader:
        offered = {connection.topic: connection.ext.offered_qos_profiles for connection in reader.connections}
    for name, (_, how) in SENT.items():
        (profile,) = offered[full_names[name]]
        assert profile.reliability == QosReliability[how.reliability.name]
        assert profile.durability == QosDurability[how.durability.name]


def test_a_recorder_that_stalls_for_seconds_misses_nothing(ros, tmp_path, publishers):
    recorded = Recorded(ros, tmp_path)
    publisher = publishers()["mocap/odom"]
    for number in range(800):
        publisher.publish(Odometry(child_frame_id=str(number)))
        time.sleep(0.001)  # nothing is taken meanwhile
    heard = []
    recorded.topics.listen("mocap/odom", lambda message, _: heard.append(message.child_frame_id))
    assert recorded.taken(lambda: len(heard) == 800)
    assert heard == [str(number) for number in range(800)]
    recorded.file.finish()
    rows = list(raw_messages(recorded.path, ["/robot1/mocap/odom"]))
    assert [row.number for row in rows] == list(range(1, 801))
    # a message's time is when it came, not when it was taken
    assert rows[-1].came - rows[0].came > 500_000_000


def test_what_cannot_be_read_is_recorded_and_handed_to_nobody_and_what_was_latched_before_too(
    ros, tmp_path, publishers
):
    found = publishers(matched=False)
    found["maneuver"].publish(SENT["maneuver"][0])
    recorded = Recorded(ros, tmp_path)
    plans, maneuvers = [], []
    recorded.topics.listen("plan", lambda message, _: plans.append(message))
    recorded.topics.listen("maneuver", lambda message, _: maneuvers.append(message.data))
    assert recorded.taken(lambda: maneuvers == ["flow_through"])
    assert ros.wait_until(found["plan"].get_subscription_count)
    found["plan"].publish(b"\0\1\0\0\xff\xff\xff\xff\xff\xff\xff\xff")
    recorded.taken(lambda: False, 0.5)
    found["plan"].publish(Path())
    assert recorded.taken(lambda: plans)
    assert plans == [Path()]
    recorded.file.finish()
    assert len(list(raw_messages(recorded.path, ["/robot1/plan"]))) == 2
