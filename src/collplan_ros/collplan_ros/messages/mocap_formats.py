"""The message formats in which motion-capture receivers publish poses; their packages are imported on demand.

Formats, by `mocap.format`, and known publishers:

pose                  vrpn_mocap, natnet_ros2, newer vicon_receiver, the simulator
pose_with_covariance  localisation packages
odometry              mocap_optitrack, localisation packages
transform             ports of vicon_bridge
tf                    any broadcaster of transforms
named_poses           motion_capture_tracking
rigid_bodies          the drivers of MOCAP4ROS2
vicon                 older vicon_receiver, in millimetres
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from collplan_core.parameters import Mocap
from collplan_core.parameters.spec import ParameterError
from collplan_core.poses.mocap_body import MeasuredPose
from collplan_core.poses.pose_filter import PoseError
from collplan_ros.messages.reading import place_fields, seconds_from_stamp

ABSENT = "absent"


@dataclass(frozen=True)
class Format:
    """A message format."""

    packages: tuple[str, ...]  # that define the message, the newest name first
    message: str
    read: Callable[[Any, str], MeasuredPose | None]  # pose of a subject in a message; None where of another body
    several: bool = False  # whether a message holds several bodies


def message_type(mocap: Mocap) -> type:
    """The message class of `mocap.format`.

    ParameterError: none of its packages is installed, or `mocap.subject` is empty and the format needs one.
    """
    chosen = FORMATS[mocap.format]
    if chosen.several and not mocap.subject:
        raise ParameterError(f"mocap.subject: got '', expected the name of a body in {chosen.message}")
    for package in chosen.packages:
        try:
            return getattr(import_module(f"{package}.msg"), chosen.message)
        except (ImportError, AttributeError):
            continue
    raise ParameterError(
        f"mocap.format: got {mocap.format!r}, expected one whose messages are installed; "
        f"{chosen.message} of {' or '.join(chosen.packages)} is not"
    )


def _measured(header: Any, position: Any, quaternion: Any) -> MeasuredPose:
    return MeasuredPose(
        str(header.frame_id),
        seconds_from_stamp(header.stamp),
        *place_fields(position, quaternion),
    )


def _from_pose(message: Any, subject: str) -> MeasuredPose:
    return _measured(message.header, message.pose.position, message.pose.orientation)


def _from_pose_with_covariance(message: Any, subject: str) -> MeasuredPose:
    return _measured(message.header, message.pose.pose.position, message.pose.pose.orientation)


def _from_transform(message: Any, subject: str) -> MeasuredPose | None:
    if subject and message.child_frame_id != subject:
        return None
    return _measured(message.header, message.transform.translation, message.transform.rotation)


def _from_transforms(message: Any, subject: str) -> MeasuredPose | None:
    for transform in message.transforms:
        if transform.child_frame_id == subject:
            return _from_transform(transform, subject)
    # others broadcast there too
    return None


def _from_named_poses(message: Any, subject: str) -> MeasuredPose:
    pose = _named(subject, ((body.name, body.pose) for body in message.poses))
    return _measured(message.header, pose.position, pose.orientation)


def _from_rigid_bodies(message: Any, subject: str) -> MeasuredPose:
    pose = _named(subject, ((body.rigid_body_name, body.pose) for body in message.rigidbodies))
    return _measured(message.header, pose.position, pose.orientation)


def _from_vicon(message: Any, subject: str) -> MeasuredPose | None:
    if subject and subject not in (message.subject_name, f"{message.subject_name}.{message.segment_name}"):
        return None
    # the oldest have no header
    header = getattr(message, "header", None)
    return MeasuredPose(
        (header and str(header.frame_id)) or None,
        header and seconds_from_stamp(header.stamp),
        (float(message.x_trans), float(message.y_trans), float(message.z_trans)),
        (float(message.x_rot), float(message.y_rot), float(message.z_rot), float(message.w)),
    )


def _named(subject: str, poses: Iterable[tuple[str, Any]]) -> Any:
    names = []
    for name, pose in poses:
        if name == subject:
            return pose
        names.append(name)
    raise PoseError(ABSENT, f"mocap.subject {subject!r}: not seen, only {', '.join(names) or 'no body'}")


FORMATS = {
    "pose": Format(("geometry_msgs",), "PoseStamped", _from_pose),
    "pose_with_covariance": Format(("geometry_msgs",), "PoseWithCovarianceStamped", _from_pose_with_covariance),
    "odometry": Format(("nav_msgs",), "Odometry", _from_pose_with_covariance),
    "transform": Format(("geometry_msgs",), "TransformStamped", _from_transform),
    "tf": Format(("tf2_msgs",), "TFMessage", _from_transforms, True),
    "named_poses": Format(("motion_capture_tracking_interfaces",), "NamedPoseArray", _from_named_poses, True),
    "rigid_bodies": Format(("mocap4r2_msgs", "mocap_msgs"), "RigidBodies", _from_rigid_bodies, True),
    "vicon": Format(("vicon_receiver", "vicon_msgs"), "Position", _from_vicon),
}
"""Formats by the value of `mocap.format`."""
