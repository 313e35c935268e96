"""The shapes of the receivers' messages, and the parameter sets shipped for them."""

import math
import sys
from dataclasses import dataclass, field
from importlib.resources import files
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Pose, PoseStamped, PoseWithCovarianceStamped, Quaternion, TransformStamped
from nav_msgs.msg import Odometry
from ros_fixture import UNTIMED
from std_msgs.msg import Header

from collplan_core.parameters import Mocap, Settings
from collplan_core.parameters.file import read_parameters
from collplan_core.parameters.spec import ParameterError
from collplan_core.sensing.pose_filter import PoseError
from collplan_ros.messages.conversions import header, state_from_odometry
from collplan_ros.messages.mocap_formats import FORMATS, message_type
from collplan_ros.messages.qos import POSE_SUBSCRIBED
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


def test_every_shape_is_read(everything_installed):
    for name, shape in FORMATS.items():
        measured = shape.read(MESSAGES[name](), "puck")
        assert (measured.frame, measured.stamp, measured.position) == ("map", 5.25, (1.0, 2.0, 0.1)), name
        assert measured.quaternion == pytest.approx((0.0, 0.0, math.sin(0.2), math.cos(0.2)))
        assert message_type(Mocap(format=name, subject="puck")).__name__ == shape.message
    oldest = FORMATS["vicon"].read(position(OldPosition), "puck.root")
    assert (oldest.frame, oldest.stamp, oldest.position) == (None, None, (1.0, 2.0, 0.1))


def test_an_absent_body_is_told_messages_about_others_are_passed_over_and_one_body_needs_no_name():
    for name in ("named_poses", "rigid_bodies"):
        with pytest.raises(PoseError, match=r"'truck'.* wand, puck") as error:
            FORMATS[name].read(MESSAGES[name](), "truck")
        assert error.value.reason == "absent"
    for name in ("tf", "transform", "vicon"):
        assert FORMATS[name].read(MESSAGES[name](), "truck") is None
    for name in ("transform", "vicon"):
        assert FORMATS[name].read(MESSAGES[name](), "") is not None


def test_packages_that_are_missing_are_named(monkeypatch, ros):
    for name in ("tf", "named_poses", "rigid_bodies", "vicon"):
        for one in FORMATS[name].packages:
            monkeypatch.setitem(sys.modules, one, None)
        with pytest.raises(ParameterError, match=rf"mocap\.format: got '{name}'.*{FORMATS[name].packages[0]}"):
            ros.make(MocapNode, {"mocap.format": name, "mocap.subject": "puck"})


def test_a_body_among_several_needs_a_name(everything_installed):
    for name in ("tf", "named_poses", "rigid_bodies"):
        with pytest.raises(ParameterError, match=r"mocap\.subject: got ''"):
            message_type(Mocap(format=name))


# ---- the node, fed by hand where the messages exist as fakes only


class HandFed(MocapNode):
    """Takes its poses from `take`, whatever their type; what it refuses is in `refused`."""

    def create_subscription(self, message_type, topic, callback, qos, **kwargs):
        if topic != self.get_parameter("mocap.topic").value:
            return super().create_subscription(message_type, topic, callback, qos, **kwargs)
        self.topic = topic
        self.take = lambda message: callback(message, UNTIMED)
        return None


SETS = sorted(path.name for path in (files("collplan_ros") / "config").iterdir() if path.name.startswith("mocap_"))


def test_each_shipped_set_starts_a_node_and_takes_its_messages(everything_installed, ros):
    assert len(SETS) == 10
    odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    for name in SETS:
        path = str(files("collplan_ros") / "config" / name)
        mocap = Settings().with_values(read_parameters(path)).mocap
        # by ROS's own reader too, which takes y for true
        node = ros.make(HandFed, cli_args=["--ros-args", "--params-file", path])
        assert node.topic == mocap.topic
        assert ros.wait_until(lambda node=node: node.count_subscribers("mocap/odom"))
        for k in range(8):
            message = MESSAGES[mocap.format]()
            stamped = message.transforms[1] if mocap.format == "tf" else message
            stamped.header = header(5.25 + 0.01 * k, mocap.frame or "map")
            set_upright(message)
            shift(message, 1e-3 * k)
            rename(message, mocap.subject)
            node.take(message)
        assert ros.wait_until(lambda: odometry), name
        ros.remove(node)
        odometry.clear()


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


def shift(message, distance):
    """Moves every body in a message along each axis, so that no pose repeats the last."""
    for name in ("x", "y", "z"):
        if hasattr(message, f"{name}_trans"):
            setattr(message, f"{name}_trans", getattr(message, f"{name}_trans") + distance)
    for part in ("position", "translation"):
        if hasattr(message, part):
            getattr(message, part).x += distance
            getattr(message, part).y += distance
    for part in ("pose", "transform", "poses", "transforms", "rigidbodies"):
        inner = getattr(message, part, None)
        for each in inner if isinstance(inner, list) else [inner] if inner is not None else []:
            shift(each, distance)


def test_a_message_without_stamp_is_stamped_on_receipt(everything_installed, ros):
    odometry = ros.listen(Odometry, "mocap/odom", POSE_SUBSCRIBED)
    node = ros.make(HandFed, {"mocap.format": "vicon", "mocap.units": "mm"})
    assert ros.wait_until(lambda: node.count_subscribers("mocap/odom"))
    before = 1e-9 * node.get_clock().now().nanoseconds
    for k in range(10):
        message = position(OldPosition)
        shift(message, 1.0 * k)
        node.take(message)
        ros.spin(0.01)
    assert ros.wait_until(lambda: odometry)
    newest = state_from_odometry(odometry[-1], "map", "base_link")
    assert before <= newest.stamp <= 1e-9 * node.get_clock().now().nanoseconds
    np.testing.assert_allclose(newest.position, [0.010, 0.011], atol=1e-6)
