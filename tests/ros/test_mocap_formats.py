"""The shapes of the receivers' messages, and the parameter sets shipped for them."""

import math
import sys
from dataclasses import dataclass, field
from importlib.resources import files
from types import ModuleType
from typing import Any

import pytest
from geometry_msgs.msg import Pose, PoseStamped, PoseWithCovarianceStamped, Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from ros_fixture import UNTIMED
from std_msgs.msg import Header

from collplan_core.parameters import Mocap, Settings
from collplan_core.parameters.file import read_parameters
from collplan_core.parameters.spec import ParameterError
from collplan_core.sensing.pose_filter import PoseError
from collplan_ros.messages.conversions import header
from collplan_ros.messages.mocap_formats import FORMATS, message_type
from collplan_ros.nodes.mocap_node import MocapNode

# Messages of packages that are not among the wheels, with the same fields.


@dataclass
class NamedPose:
    name: str
    pose: Pose


@dataclass
class NamedPoseArray:
    header: Header
    poses: list[NamedPose]


@dataclass
class RigidBody:
    rigid_body_name: str
    pose: Pose
    markers: list[Any] = field(default_factory=list)


@dataclass
class RigidBodies:
    header: Header
    frame_number: int
    rigidbodies: list[RigidBody]


@dataclass
class TFMessage:
    transforms: list[TransformStamped]


@dataclass
class OldPosition:
    """Position message of vicon_receiver before it had stamps."""

    x_trans: float
    y_trans: float
    z_trans: float
    x_rot: float
    y_rot: float
    z_rot: float
    w: float
    subject_name: str
    segment_name: str


@dataclass
class Position(OldPosition):
    header: Header


FAKES = {
    "tf2_msgs": TFMessage,
    "motion_capture_tracking_interfaces": NamedPoseArray,
    "mocap4r2_msgs": RigidBodies,
    "vicon_receiver": Position,
}
HEADER = header(5.25, "map")


def fake(monkeypatch, package):
    module = ModuleType(f"{package}.msg")
    setattr(module, FAKES[package].__name__, FAKES[package])
    monkeypatch.setitem(sys.modules, package, ModuleType(package))
    monkeypatch.setitem(sys.modules, f"{package}.msg", module)


@pytest.fixture
def everything_installed(monkeypatch):
    for package in FAKES:
        fake(monkeypatch, package)


def placed(pose):
    """The pose that every message here holds for the robot."""
    pose.position.x, pose.position.y, pose.position.z = 1.0, 2.0, 0.1
    pose.orientation.z, pose.orientation.w = math.sin(0.2), math.cos(0.2)
    return pose


def transform(child="puck"):
    message = TransformStamped(header=HEADER, child_frame_id=child)
    pose = placed(Pose())
    message.transform.translation.x, message.transform.translation.y = pose.position.x, pose.position.y
    message.transform.translation.z, message.transform.rotation = pose.position.z, pose.orientation
    return message


def pose_with_covariance(kind):
    message = kind(header=HEADER)
    placed(message.pose.pose)
    return message


def position(kind, *head):
    return kind(1.0, 2.0, 0.1, 0.0, 0.0, math.sin(0.2), math.cos(0.2), "puck", "root", *head)


OTHER = Pose()
MESSAGES = {
    "pose": lambda: PoseStamped(header=HEADER, pose=placed(Pose())),
    "pose_with_covariance": lambda: pose_with_covariance(PoseWithCovarianceStamped),
    "odometry": lambda: pose_with_covariance(Odometry),
    "transform": transform,
    "tf": lambda: TFMessage([TransformStamped(header=header(9.0, "odom"), child_frame_id="arm"), transform()]),
    "named_poses": lambda: NamedPoseArray(HEADER, [NamedPose("wand", OTHER), NamedPose("puck", placed(Pose()))]),
    "rigid_bodies": lambda: RigidBodies(HEADER, 7, [RigidBody("wand", OTHER), RigidBody("puck", placed(Pose()))]),
    "vicon": lambda: position(Position, HEADER),
}


@pytest.mark.parametrize("name", FORMATS)
def test_every_shape_is_read(name):
    measured = FORMATS[name].read(MESSAGES[name](), "puck")
    assert (measured.frame, measured.stamp, measured.position) == ("map", 5.25, (1.0, 2.0, 0.1))
    assert measured.quaternion == pytest.approx((0.0, 0.0, math.sin(0.2), math.cos(0.2)))


def test_oldest_vicon_receiver_has_neither_stamp_nor_frame():
    measured = FORMATS["vicon"].read(position(OldPosition), "puck.root")
    assert (measured.frame, measured.stamp, measured.position) == (None, None, (1.0, 2.0, 0.1))


@pytest.mark.parametrize("name", ["named_poses", "rigid_bodies"])
def test_an_absent_body_is_told_with_those_that_are_there(name):
    with pytest.raises(PoseError, match="'truck': not seen, only wand, puck") as error:
        FORMATS[name].read(MESSAGES[name](), "truck")
    assert error.value.reason == "absent"


@pytest.mark.parametrize("name", ["tf", "transform", "vicon"])
def test_messages_about_others_are_passed_over(name):
    assert FORMATS[name].read(MESSAGES[name](), "truck") is None


def test_one_body_needs_no_name():
    assert FORMATS["transform"].read(transform("anything"), "") is not None
    assert FORMATS["vicon"].read(position(Position, HEADER), "") is not None


@pytest.mark.parametrize("name", FORMATS)
def test_message_types_are_found_where_they_are_installed(everything_installed, name):
    assert message_type(Mocap(format=name, subject="puck")).__name__ == FORMATS[name].message


def test_older_name_of_the_package_will_do(monkeypatch):
    fake(monkeypatch, "mocap4r2_msgs")
    monkeypatch.setitem(sys.modules, "mocap_msgs", sys.modules.pop("mocap4r2_msgs"))
    monkeypatch.setitem(sys.modules, "mocap_msgs.msg", sys.modules.pop("mocap4r2_msgs.msg"))
    assert message_type(Mocap(format="rigid_bodies", subject="puck")) is RigidBodies


@pytest.mark.parametrize(
    ("name", "package"),
    [
        ("tf", "tf2_msgs"),
        ("named_poses", "motion_capture_tracking_interfaces"),
        ("rigid_bodies", "mocap4r2_msgs"),
        ("vicon", "vicon_receiver"),
    ],
)
def test_a_package_that_is_missing_is_named(monkeypatch, ros, name, package):
    for one in FORMATS[name].packages:
        monkeypatch.setitem(sys.modules, one, None)
    with pytest.raises(ParameterError, match=rf"mocap\.format: got '{name}'.*{package}.* is not"):
        ros.make(MocapNode, {"mocap.format": name, "mocap.subject": "puck"})


@pytest.mark.parametrize("name", ["tf", "named_poses", "rigid_bodies"])
def test_a_body_among_several_needs_a_name(everything_installed, name):
    with pytest.raises(ParameterError, match=r"mocap\.subject: got ''"):
        message_type(Mocap(format=name))


# ---- the node, fed by hand where the messages exist as fakes only


class HandFed(MocapNode):
    """Takes its poses from `take`, whatever their type."""

    def create_subscription(self, message_type, topic, callback, qos, raw=False):
        if topic != self._settings.mocap.topic:
            return super().create_subscription(message_type, topic, callback, qos, raw=raw)
        self.topic, self.qos = topic, qos
        self.take = lambda message: callback(message, UNTIMED)
        return None


SETS = sorted(path.name for path in (files("collplan_ros") / "config").iterdir() if path.name.startswith("mocap_"))


def test_sets_are_shipped():
    assert len(SETS) == 10


@pytest.mark.parametrize("name", SETS)
def test_a_shipped_set_starts_a_node_and_takes_its_messages(everything_installed, ros, name):
    path = str(files("collplan_ros") / "config" / name)
    mocap = Settings().with_values(read_parameters(path)).mocap
    # by ROS's own reader too, which takes y for true
    node = ros.make(HandFed, cli_args=["--ros-args", "--params-file", path])
    assert node._settings.mocap == mocap
    assert node.topic == mocap.topic
    message = MESSAGES[mocap.format]()
    stamped = message.transforms[1] if mocap.format == "tf" else message
    stamped.header = header(5.25, mocap.frame or "map")
    set_upright(message)
    rename(message, mocap.subject)
    node.take(message)
    assert (node._counts["received"], node._inputs.refusals.newest) == (1, "")
    assert len(node._memory.track.times) == 1


def set_upright(message):
    """Turns every body in a message back, whichever axis points up."""
    for part in ("pose", "transform", "poses", "transforms", "rigidbodies"):
        inner = getattr(message, part, None)
        for each in inner if isinstance(inner, list) else [inner] if inner is not None else []:
            set_upright(each)
    for name in ("orientation", "rotation"):
        if hasattr(message, name):
            setattr(message, name, Quaternion(w=1.0))


def rename(message, subject):
    """Gives the robot's body in a message the name that a set looks for."""
    for body in getattr(message, "poses", []):
        body.name = subject if body.name == "puck" else body.name
    for body in getattr(message, "rigidbodies", []):
        body.rigid_body_name = subject if body.rigid_body_name == "puck" else body.rigid_body_name
    for one in getattr(message, "transforms", []):
        one.child_frame_id = subject if one.child_frame_id == "puck" else one.child_frame_id
    if hasattr(message, "subject_name"):
        message.subject_name = subject


def test_a_message_without_stamp_is_stamped_on_receipt(everything_installed, ros):
    node = ros.make(HandFed, {"mocap.format": "vicon", "mocap.units": "mm"})
    before = 1e-9 * node.get_clock().now().nanoseconds
    node.take(position(OldPosition))
    (stamp,) = node._memory.track.times
    assert before <= stamp <= 1e-9 * node.get_clock().now().nanoseconds
    assert node._memory.track.poses[:, :2].tolist() == [[0.001, 0.002]]
