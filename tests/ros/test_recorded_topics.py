"""What is recorded of a graph: every topic that a node publishes, with a definition that two libraries read."""

import json
import re
import sys
from pathlib import Path

import pytest
import yaml

from collplan_core.parameters import Settings
from collplan_ros.messages.qos import EVERY_ONE, EVERY_UNRELIABLE
from collplan_ros.run.schemas import schema_text, type_name
from collplan_ros.run.topics import recorded_topics

SOURCES = Path(__file__).parents[2] / "src"
TOPICS = recorded_topics(Settings())
NOT_RECORDED = {"/tf", "planner/markers"}
"""Where tf2_msgs is not installed; and what is only for RViz."""
ONLY_WITH_SIMULATED_TIME = {"/clock"}


def test_every_topic_that_is_published_is_recorded():
    published = set()
    for path in SOURCES.glob("*/*/**/*.py"):
        published |= set(re.findall(r'create_publisher\(\s*[\w()]+,\s*"([^"]+)"', path.read_text()))
    assert len(published) > 20
    timed = recorded_topics(Settings().with_values({"simulator.speed_factor": 2.0}))
    assert published - set(timed) <= NOT_RECORDED
    assert set(timed) - set(TOPICS) == ONLY_WITH_SIMULATED_TIME


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


def test_definitions_are_found_where_no_ros_is_sourced(monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    if not (Path(sys.prefix) / "share" / "nav_msgs").is_dir():
        pytest.skip("ROS is not from pip here")
    assert schema_text.__wrapped__("nav_msgs/msg/Path") == schema_text("nav_msgs/msg/Path")


def test_the_layouts_of_foxglove_and_rviz_show_topics_that_are_recorded_or_for_rviz_alone():
    folder = SOURCES / "collplan_ros/collplan_ros"
    panels = json.loads((folder / "foxglove/collplan.json").read_text())["configById"]
    shown = set(panels["3D!arena"]["topics"])
    shown |= {path["value"].split(".")[0] for panel in panels.values() for path in panel.get("paths", ())}
    manager = yaml.safe_load((folder / "rviz/collplan.rviz").read_text())["Visualization Manager"]
    shown |= {f"/{each['Topic']['Value']}" for each in [*manager["Displays"], *manager["Tools"]] if "Topic" in each}
    assert len(shown) > 10
    assert shown - {name if name.startswith("/") else f"/{name}" for name in TOPICS} == {"/planner/markers"}


def test_the_picture_of_the_nodes_names_those_that_are_there_and_their_topics():
    picture = (SOURCES.parent / "docs" / "pictures" / "node_graph.svg").read_text()
    words = {word for word in re.findall(r">([^<>]+)</text>", picture) if re.fullmatch(r"[a-z]+[a-z_/]*[a-z]", word)}
    nodes = {path.stem for path in SOURCES.glob("*/*/**/*_node.py") if path.parent.name != "node_kit"}
    assert nodes - words == set()
    assert words - nodes - {"or", "firmware_emulator"} - TOPICS.keys() - NOT_RECORDED == set()
