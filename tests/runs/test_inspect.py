"""inspect reads a recording of any robot, and writes what it shows of the sensors."""

import json
import os
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from driven_robots import ANGLES, BETWEEN, TURN, Drive, drawn_mount, driven
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from collplan_core.mounting.driven import Driven
from collplan_core.parameters import Settings
from collplan_core.parameters.file import read_parameters
from collplan_core.state import State
from collplan_ros.inspect.main import GOOD, UNREADABLE, main
from collplan_ros.inspect.page import Drawing
from collplan_ros.inspect.recording import Topics, read_recording
from played_folders import newest, poses_in, recording_in

EPOCH = 1_700_000_000.0
TRANSIT = 0.005
"""Time from an odometry's stamp to its receipt [s]."""
KILLED = Path(__file__).parents[1] / "frozen/runs/killed"
TURTLEBOT = Path(os.environ.get("COLLPLAN_RECORDINGS", "none")) / "turtlebot4_hall.mcap"


class Bag:
    """Messages of a version of ROS, written to a bag as they are received."""

    def __init__(self, writer: Any, ros1: bool) -> None:
        self.writer, self.ros1 = writer, ros1
        self.store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)
        self.connections: dict[str, Any] = {}

    def make(self, name: str, *args: Any) -> Any:
        return self.store.types[name](*args)

    def header(self, stamp: float, frame: str) -> Any:
        nanoseconds = round((EPOCH + stamp) * 1e9)
        time = self.make("builtin_interfaces/msg/Time", nanoseconds // 10**9, nanoseconds % 10**9)
        return self.make("std_msgs/msg/Header", *((0,) if self.ros1 else ()), time, frame)

    def write(self, topic: str, kind: str, message: Any, received: float) -> None:
        if topic not in self.connections:
            self.connections[topic] = self.writer.add_connection(topic, kind, typestore=self.store)
        serialise = self.store.serialize_ros1 if self.ros1 else self.store.serialize_cdr
        self.writer.write(self.connections[topic], round((EPOCH + received) * 1e9), serialise(message, kind))

    def odometry(self, stamp: float, x: float, y: float, yaw: float) -> Any:
        make, none = self.make, np.zeros(36)
        turn = make("geometry_msgs/msg/Quaternion", 0.0, 0.0, float(np.sin(yaw / 2.0)), float(np.cos(yaw / 2.0)))
        pose = make("geometry_msgs/msg/Pose", make("geometry_msgs/msg/Point", x, y, 0.0), turn)
        still = make("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
        twist = make("geometry_msgs/msg/TwistWithCovariance", make("geometry_msgs/msg/Twist", still, still), none)
        covered = make("geometry_msgs/msg/PoseWithCovariance", pose, none)
        return make("nav_msgs/msg/Odometry", self.header(stamp, "odom"), "base_link", covered, twist)

    def scan(self, stamp: float, ranges: np.ndarray) -> Any:
        header, step = self.header(stamp, "laser"), float(ANGLES[1] - ANGLES[0])
        angles = float(ANGLES[0]), float(ANGLES[-1]), step
        values = np.asarray(ranges, np.float32), np.zeros(0, np.float32)
        return self.make("sensor_msgs/msg/LaserScan", header, *angles, BETWEEN, TURN, 0.05, 12.0, *values)


def write_bag(folder: Path, form: str, recorded: Driven) -> Path:
    """Writes a drive; returns the path that a user gives."""
    path = folder / ("drive.bag" if form == "ros1" else "drive")
    plugin = StoragePlugin.MCAP if form == "mcap" else StoragePlugin.SQLITE3
    writer = Writer1(path) if form == "ros1" else Writer2(path, version=9, storage_plugin=plugin)
    with writer:
        bag, scans = Bag(writer, form == "ros1"), list(zip(recorded.stamps, recorded.ranges, strict=True))
        for time, pose in zip(recorded.times, recorded.poses, strict=True):
            while scans and scans[0][0] < time:
                stamp, ranges = scans.pop(0)
                bag.write("/front/scan", "sensor_msgs/msg/LaserScan", bag.scan(stamp, ranges), stamp)
            bag.write("/odom", "nav_msgs/msg/Odometry", bag.odometry(time, *pose.tolist()), time + TRANSIT)
    return next(path.glob("*.mcap")) if form == "mcap" else path


def test_every_form_of_a_bag_is_read_and_of_one_that_is_cut_off_what_it_holds(tmp_path):
    recorded = driven(drawn_mount(1), Drive(moves=False), duration=4.0)
    for form, name in (("ros1", ""), ("sqlite", ""), ("sqlite", "drive.db3"), ("mcap", ""), ("mcap", "drive.mcap")):
        folder = tmp_path / f"{form}{name}"
        folder.mkdir()
        write_bag(folder, form, recorded)
        path = folder / ("drive.bag" if form == "ros1" else "drive") / name
        found = read_recording(path, Topics(), Settings().mocap, lambda _: None)
        assert (len(found.poses), len(found.scans), found.is_cut) == (len(recorded.times), len(recorded.stamps), False)
    bag = tmp_path / "bag"  # whose recorder was killed, as bringup was
    bag.mkdir()
    shutil.copy(KILLED / "run.mcap", bag / "bag_0.mcap")
    for path in (KILLED, bag, bag / "bag_0.mcap"):
        found = read_recording(path, Topics(), Settings().mocap, lambda _: None)
        assert (len(found.poses), len(found.scans), found.is_cut) == (526, 104, True)


def test_found_parameters_are_those_of_the_robot(tmp_path, capsys):
    true = drawn_mount(3)
    path = write_bag(tmp_path, "ros1", driven(true, Drive(), duration=15.0, seed=3))
    assert main([str(path), "--out", str(tmp_path / "out")]) == GOOD
    report = json.loads((tmp_path / "out/inspect.json").read_text())
    assert report["as_set"]["scans"]["refused"] > 0.1 * report["as_set"]["scans"]["n"]
    assert report["as_found"]["scans"]["refused"] == report["as_found"]["scans"]["held"] == 0
    assert {key: each["value"] for key, each in report["found"].items()} == read_parameters(tmp_path / "out/found.yaml")
    drawn = {"stamp_offset": true.late, "offset_x": true.x, "offset_y": true.y, "offset_yaw": true.yaw}
    for key, value in drawn.items():
        found = report["found"][f"scan.{key}"]
        assert abs(found["value"] - value) < found["uncertainty"], key
    assert report["found"]["scan.mirrored"]["value"] == true.mirrored
    assert report["found"]["mocap.topic"]["value"] == "/odom"
    assert "mended" in capsys.readouterr().out
    frames = recording_in((tmp_path / "out/inspect.html").read_text(encoding="utf-8"))["frames"]
    placed = poses_in([frame for frame in frames if "robot" in frame])
    assert 0 <= report["as_found"]["poses"]["n"] - len(placed) < 10  # the first ones give no velocity
    assert sum("scan" in frame for frame in frames) > 0.9 * report["as_found"]["scans"]["n"]
    assert len(newest(frames, "remembered", np.inf)) > 400


def test_the_page_marks_what_was_refused_where_it_was_and_says_why():
    states = [State(0.1 * k, np.array([0.1 * k, 0.0]), np.array([1.0, 0.0]), 0.0) for k in range(40)]
    happened = [(EPOCH + each.stamp, "pose", (each,)) for each in states]
    happened.append((EPOCH + 1.03, "refused_pose", ("leap", np.array([5.0, 2.0]))))
    happened.append((EPOCH + 1.04, "refused_pose", ("not_finite", None)))
    happened.append((EPOCH + 2.05, "refused_scan", ("it is turned", None, states[20])))
    happened.append((EPOCH + 3.02, "stands", ("scan too old",)))
    frames = Drawing(Settings()).frames_of("drive", sorted(happened, key=lambda each: each[0]))
    marked = {round(frame["t"], 1): frame["refused"] for frame in frames if "refused" in frame}
    assert marked == {1.1: [[5000, 2000, 0], [1000, 0, 0]], 2.1: [[2000, 0, 1]]}
    reasons = [newest(frames, "doing", time)["reason"] for time in (0.5, 1.1, 2.1, 3.3)]
    assert reasons == ["", "pose refused: not_finite", "scan refused: it is turned", "scan too old"]


def test_what_a_robot_at_rest_does_not_show_is_not_written_and_a_line_says_what_would(tmp_path, capsys):
    path = write_bag(tmp_path, "mcap", driven(drawn_mount(1)._replace(late=0.0), Drive(moves=False), duration=6.0))
    (given := tmp_path / "base.yaml").write_text("/**: {ros__parameters: {robot: {radius: 0.15}}}")
    main([str(path), "--params", str(given), "--out", str(tmp_path)])
    wiring = {"mocap.format", "mocap.topic", "mocap.frame", "mocap.axes", "scan.frame"}
    assert set(read_parameters(tmp_path / "found.yaml")) == {*wiring, "robot.radius"}
    assert "scan.offset_yaw" in json.loads((tmp_path / "inspect.json").read_text())["missing"]
    assert "turn once at about 1 rad/s" in capsys.readouterr().out


def test_what_cannot_be_read_ends_with_code_2_and_names_the_file(tmp_path, capsys):
    cut, text = tmp_path / "cut.mcap", tmp_path / "notes.txt"
    cut.write_bytes(b"\x89MCAP0\r\n and no more")
    text.write_text("no recording")
    path = write_bag(tmp_path, "sqlite", driven(drawn_mount(1), Drive(moves=False), duration=4.0))
    for args in ([tmp_path / "none"], [cut], [text], [path, "--scans", "/scan"], [path, "--params", text]):
        assert main([*map(str, args), "--out", str(tmp_path)]) == UNREADABLE
        said = capsys.readouterr().err
        assert "expected" in said
        assert str(args[-1]) in said or "/scan" in said
    assert not (tmp_path / "found.yaml").exists()


@pytest.mark.skipif(not TURTLEBOT.exists(), reason="COLLPLAN_RECORDINGS is no folder of real recordings")
def test_a_real_turtlebot_is_driven_with_what_its_own_recording_shows(tmp_path):
    assert main([str(TURTLEBOT), "--out", str(tmp_path)]) == GOOD
    report = json.loads((tmp_path / "inspect.json").read_text())
    scan = read_parameters(tmp_path / "found.yaml")
    assert abs(scan["scan.offset_yaw"] - np.pi / 2.0) < np.radians(2.0)
    assert scan["scan.backwards"] is True
    assert np.hypot(scan["scan.offset_x"] - 0.0039, scan["scan.offset_y"]) < 0.02
    assert abs(scan["scan.stamp_offset"] + 0.17) < 0.03
    assert report["as_set"]["scans"]["held"] > report["as_found"]["scans"]["held"] == 0
