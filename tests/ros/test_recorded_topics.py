"""What is recorded of a graph: every topic that a node publishes, with a definition that two libraries read."""

import json
import re
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from any_message import messages, plain
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.records import Schema
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap_ros2.decoder import DecoderFactory
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from collplan_core.parameters import Settings
from collplan_ros.messages.qos import EVERY_ONE, EVERY_UNRELIABLE
from collplan_ros.recording.recorded_topics import SPARSE, recorded_topics
from collplan_ros.recording.schemas import schema_text, type_name

SOURCES = Path(__file__).parents[2] / "src"
TOPICS = recorded_topics(Settings())
KINDS = {type_name(topic.kind): topic.kind for topic in TOPICS.values()}
ONLY_WITH_SIMULATED_TIME = "/clock"


def test_every_topic_that_is_published_is_recorded():
    published = set()
    for path in SOURCES.glob("*/*/**/*.py"):
        published |= set(re.findall(r'create_publisher\(\s*[\w()]+,\s*"([^"]+)"', path.read_text()))
    assert len(published) > 20
    timed = recorded_topics(Settings().with_values({"simulator.speed_factor": 2.0}))
    assert published - set(timed) == set()
    assert set(timed) - set(TOPICS) == {ONLY_WITH_SIMULATED_TIME}
    assert set(TOPICS) >= set(SPARSE)


def test_the_poses_of_a_receiver_are_recorded_as_they_are_published():
    values = {"mocap.topic": "vrpn/body", "mocap.format": "transform", "mocap.reliability": "reliable"}
    topic = recorded_topics(Settings().with_values(values))["vrpn/body"]
    assert (type_name(topic.kind), topic.qos) == ("geometry_msgs/msg/TransformStamped", EVERY_ONE)
    assert recorded_topics(Settings())["mocap/pose"].qos == EVERY_UNRELIABLE
    # its messages are not installed here, and mocap_node says so
    missing = recorded_topics(Settings().with_values({"mocap.topic": "poses", "mocap.format": "named_poses"}))
    assert "poses" not in missing


def test_stamped_commands_are_recorded_as_such():
    stamped = recorded_topics(Settings().with_values({"controller.stamped_cmd_vel": True}))
    assert type_name(stamped["cmd_vel"].kind) == "geometry_msgs/msg/TwistStamped"


def test_a_definition_is_joined_as_rosbag2_joins_it():
    text = schema_text("geometry_msgs/msg/PointStamped")
    beginnings = re.findall(r"^(?:=+\nMSG: (.*)|# .*)$", text, re.MULTILINE)
    joined = ["geometry_msgs/Point", "std_msgs/Header", "builtin_interfaces/Time"]
    assert [name for name in beginnings if name] == joined
    assert f"\n\n{'=' * 80}\nMSG: geometry_msgs/Point\n# " in text
    assert schema_text("std_msgs/msg/Empty") == ""
    assert schema_text("std_msgs/msg/NoSuchType") is None


def test_definitions_are_found_where_no_ros_is_sourced(monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    if not (Path(sys.prefix) / "share" / "nav_msgs").is_dir():
        pytest.skip("ROS is not from pip here")
    assert schema_text.__wrapped__("nav_msgs/msg/Path") == schema_text("nav_msgs/msg/Path")


@cache
def decoders(name: str) -> tuple[Callable[[bytes], Any], ...]:
    """What decodes a type by nothing but its definition."""
    text = schema_text(name)
    schema = Schema(id=1, name=name, encoding=SchemaEncoding.ROS2, data=text.encode())
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(text, name))
    return DecoderFactory().decoder_for(MessageEncoding.CDR, schema), lambda sent: store.deserialize_cdr(sent, name)


@pytest.mark.parametrize("name", KINDS)
@given(data=st.data())
@settings(derandomize=True, deadline=None, max_examples=5, suppress_health_check=list(HealthCheck))
def test_both_libraries_decode_any_message_of_each_type(name, data):
    kind = KINDS[name]
    message = data.draw(messages(kind))
    sent, expected = serialize_message(message), plain(message, kind)
    assert plain(deserialize_message(sent, kind), kind) == expected
    for decode in decoders(name):
        assert plain(decode(sent), kind) == expected


def test_the_foxglove_layout_shows_topics_that_are_recorded_in_panels_that_it_describes():
    layout = json.loads((SOURCES / "collplan_ros/collplan_ros/foxglove/collplan.json").read_text())
    panels = layout["configById"]
    shown = set(panels["3D!arena"]["topics"])
    shown |= {path["value"].split(".")[0] for panel in panels.values() for path in panel.get("paths", ())}
    shown |= {panel["topicToRender"] for panel in panels.values() if "topicToRender" in panel}
    assert len(shown) > 10
    assert shown - {name if name.startswith("/") else f"/{name}" for name in TOPICS} == set()
    places, parts = set(), [layout["layout"]]
    while parts:
        part = parts.pop()
        if isinstance(part, str):
            places.add(part)
        else:
            parts += [part["first"], part["second"]]
    assert places == set(panels)
