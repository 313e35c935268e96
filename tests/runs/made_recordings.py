"""Recordings made by hand, of messages that need no ROS to be made."""

from pathlib import Path
from typing import Any

from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.stores.ros2_jazzy import builtin_interfaces__msg__Time as Time
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__Point as Point
from rosbags.typesys.stores.ros2_jazzy import geometry_msgs__msg__PointStamped as PointStamped
from rosbags.typesys.stores.ros2_jazzy import std_msgs__msg__Header as Header
from rosbags.typesys.stores.ros2_jazzy import std_msgs__msg__String as String

from collplan_ros.run.description import RUN
from collplan_ros.run.schemas import schema_text
from collplan_ros.run.writer import RecordingFile

STORE = get_typestore(Stores.ROS2_JAZZY)
EPOCH = 1_700_000_000_000_000_000
POINT, STRING = "geometry_msgs/msg/PointStamped", "std_msgs/msg/String"
TOPICS = {"/controller/reference": POINT} | dict.fromkeys(
    ("/maneuver", "/planner/journal", "/controller/journal"), STRING
)
QOS = """\
- history: unknown
  depth: 0
  reliability: reliable
  durability: transient_local
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: automatic
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
"""


def point(x: float, y: float, frame: str = "map") -> Any:
    return PointStamped(Header(Time(12, 345), frame), Point(x, y, 0.0))


numbers = st.floats(allow_nan=False)
texts = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=200)
contents = {POINT: st.builds(point, numbers, numbers, texts), STRING: st.builds(String, texts)}
sent = st.sampled_from(sorted(TOPICS)).flatmap(lambda topic: st.tuples(st.just(topic), contents[TOPICS[topic]]))
"""A topic and a message on it."""


def kind_of(topic: str) -> str:
    return next(kind for name, kind in TOPICS.items() if topic.endswith(name))


def cdr(topic: str, message: Any) -> bytes:
    return bytes(STORE.serialize_cdr(message, kind_of(topic)))


class MadeRecording:
    """A recording that is written message by message, one every 10 ms from `epoch` by the wall clock [ns]."""

    def __init__(self, path: Path, namespace: str = "/") -> None:
        self.path = path
        self.epoch = EPOCH
        self.file = RecordingFile(path)
        self.file.attach("parameters.yaml", "application/yaml", "/**: {}\n")
        self.file.describe(RUN, {"goal": "1.0 2.0", "simulated": "true", "namespace": namespace})
        self.file.flush()
        self.rows: list[tuple[str, int, bytes]] = []
        self._channels: dict[str, int] = {}

    def write(self, topic: str, message: Any) -> None:
        if topic not in self._channels:
            kind = kind_of(topic)
            about = {"offered_qos_profiles": QOS, "topic_type_hash": ""}
            self._channels[topic] = self.file.channel(topic, kind, schema_text(kind), about)
        came, data = self.epoch + 10_000_000 * len(self.rows), cdr(topic, message)
        self.file.write(self._channels[topic], data, came, came - 1000, len(self.rows) + 1)
        self.rows.append((topic, came, data))
