"""The shapes of the receivers' messages, and the parameter sets shipped for them; /tf is in test_transforms.py."""

import math
import sys
from dataclasses import make_dataclass
from importlib.resources import files
from types import ModuleType

import pytest
from geometry_msgs.msg import Pose, PoseStamped, PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import Odometry

from collplan_core.parameters import Mocap, Settings
from collplan_core.parameters.file import read_parameters
from collplan_core.parameters.spec import ParameterError
from collplan_core.poses.pose_filter import PoseError
from collplan_ros.messages.conversions import header
from collplan_ros.messages.mocap_formats import FORMATS, message_type
from collplan_ros.nodes.mocap_node import MocapNode

# Messages of packages that are not among the wheels, with the same fields.

NamedPose = make_dataclass("NamedPose", ["name", "pose"])
NamedPoseArray = make_dataclass("NamedPoseArray", ["header", "poses"])
RigidBody = make_dataclass("RigidBody", ["rigid_body_name", "pose"])
RigidBodies = make_dataclass("RigidBodies", ["header", "frame_number", "rigidbodies"])
PLACE = ["x_trans", "y_trans", "z_trans", "x_rot", "y_rot", "z_rot", "w", "subject_name", "segment_name"]
Position = make_dataclass("Position", [*PLACE, "header"])
OldPosition = make_dataclass("OldPosition", PLACE)
"""Of vicon_receiver before its messages had stamps."""
FAKES = {
    "motion_capture_tracking_interfaces": NamedPoseArray,
    "mocap4r2_msgs": RigidBodies,
    "vicon_receiver": Position,
}
HEADER = header(5.25, "map")


@pytest.fixture
def everything_installed(monkeypatch):
    for package, kind in FAKES.items():
        module = ModuleType(f"{package}.msg")
        setattr(module, kind.__name__, kind)
        monkeypatch.setitem(sys.modules, package, ModuleType(package))
        monkeypatch.setitem(sys.modules, f"{package}.msg", module)


def placed(pose):
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
    "named_poses": lambda: NamedPoseArray(HEADER, [NamedPose("wand", OTHER), NamedPose("puck", placed(Pose()))]),
    "rigid_bodies": lambda: RigidBodies(HEADER, 7, [RigidBody("wand", OTHER), RigidBody("puck", placed(Pose()))]),
    "vicon": lambda: position(Position, HEADER),
}


def test_every_shape_is_read(everything_installed):
    assert FORMATS.keys() - MESSAGES.keys() == {"tf"}
    for name, message in MESSAGES.items():
        shape = FORMATS[name]
        measured = shape.read(message(), "puck")
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
    for name in ("transform", "vicon"):
        assert FORMATS[name].read(MESSAGES[name](), "truck") is None
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


class Unfed(MocapNode):
    def create_subscription(self, message_type, topic, callback, qos, **kwargs):
        if topic != self.get_parameter("mocap.topic").value:
            return super().create_subscription(message_type, topic, callback, qos, **kwargs)
        self.listened = message_type.__name__, topic
        return None


SETS = {path.name for path in (files("collplan_ros") / "config").iterdir() if path.name.startswith("mocap_")}


def test_each_shipped_set_starts_a_node(everything_installed, ros):
    assert len(SETS) == 10
    for name in SETS - {"mocap_tf.yaml"}:
        path = str(files("collplan_ros") / "config" / name)
        mocap = Settings().with_values(read_parameters(path)).mocap
        # by ROS's own reader too, which takes y for true
        node = ros.make(Unfed, cli_args=["--ros-args", "--params-file", path])
        assert node.listened == (FORMATS[mocap.format].message, mocap.topic)
        ros.remove(node)
