"""What is recorded of a graph: every topic that a node publishes, with a definition that two libraries read."""

import json
import re
import sys
from pathlib import Path

import pytest

from collplan_core.parameters import Settings
from collplan_ros.messages.qos import EVERY_ONE, EVERY_UNRELIABLE
from collplan_ros.recording.recorded_topics import SPARSE, recorded_topics
from collplan_ros.recording.schemas import schema_text, type_name

SOURCES = Path(__file__).parents[2] / "src"
TOPICS = recorded_topics(Settings())
ONLY_WITH_SIMULATED_TIME = {"/clock", "lockstep"}


def test_every_topic_that_is_published_is_recorded():
    published = set()
    for path in SOURCES.glob("*/*/**/*.py"):
        published |= set(re.findall(r'create_publisher\(\s*[\w()]+,\s*"([^"]+)"', path.read_text()))
    assert len(published) > 20
    timed = recorded_topics(Settings().with_values({"simulator.speed_factor": 2.0}))
    assert published - set(timed) == set()
    assert set(timed) - set(TOPICS) == ONLY_WITH_SIMULATED_TIME
    assert set(TOPICS) >= set(SPARSE)


def test_the_poses_of_a_receiver_are_recorded_as_they_are_published():
    values = {"mocap.topic": "vrpn/body", "mocap.format": "transform", "mocap.reliability": "reliable"}
    topic = recorded_topics(Settings().with_values(values))["vrpn/body"]
    assert (type_name(topic.kind), topic.qos) == ("geometry_msgs/msg/TransformStamped", EVERY_ONE)
    assert recorded_topics(Settings())["mocap/pose"].qos == EVERY_UNRELIABLE
    # its messages are not installed here, and mocap_node says so
    missing = recorded_topics(Settings().with_values({"mocap.topic": "poses", "mocap.format": "named_poses"}))
    assert "poses" not in missing


def test_what_is_recorded_of_scans_and_stamped_commands():
    # no scan of lidar_node is left out, and those of any driver are heard
    assert TOPICS["scan"].qos == EVERY_ONE
    assert recorded_topics(Settings(), real_scans=True)["scan"].qos == EVERY_UNRELIABLE
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
