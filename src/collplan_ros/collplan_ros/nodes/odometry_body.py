"""Whether an odometry is that of the robot's frame, by its child_frame_id and the transforms on /tf_static."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.node import Node

from collplan_core.calibration.frame_chain import Link, place_in
from collplan_core.parameters import Settings
from collplan_core.poses.pose_filter import PoseError, check_pose_fields
from collplan_ros.messages.qos import LATCHED_TRANSFORMS
from collplan_ros.messages.reading import place_fields

PATIENCE = 2.0
"""Time within which transforms on /tf_static have come, once odometry comes [s]."""
NEAR, ALIGNED = 0.01, 0.02
"""A frame nearer to the robot's than this counts as the same [m, rad]."""
ON_THE_FLOOR = "base_footprint"
"""The robot's frame without its height, by REP 120."""


def take_links(links: dict[str, Link], message: Any) -> None:
    """Adds the transforms of a TFMessage to `links` by their child, without those that are none."""
    for each in message.transforms:
        position, quaternion = place_fields(each.transform.translation, each.transform.rotation)
        try:
            check_pose_fields(0.0, position, quaternion, 1e-3)
        except PoseError:
            continue  # of another device, or one that the result then lacks
        links[each.child_frame_id] = Link(each.header.frame_id, position, quaternion)


class OdometryBody:
    """Compares the body of an odometry with the robot's frame."""

    def __init__(self, node: Node, local: Callable[[], float]) -> None:
        """Listens to /tf_static through `node`, where tf2_msgs is installed; `local` is the time [s]."""
        self._links: dict[str, Link] = {}
        self._first: dict[str, float] = {}
        self._local = local
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            return
        node.create_subscription(TFMessage, "/tf_static", partial(take_links, self._links), LATCHED_TRANSFORMS)

    def why_another(self, body: str, settings: Settings) -> str:
        """Returns why `body` is not the robot's frame, and what to do; "" where it is, or its offset is a parameter."""
        mocap, base = settings.mocap, settings.frames.base
        told = mocap.body_offset_x or mocap.body_offset_y or mocap.body_offset_yaw
        waits = self._local() - self._first.setdefault(body, self._local()) < PATIENCE
        if told or waits or body.strip("/") in ("", base.strip("/")):
            return ""
        said, place = (
            f"child_frame_id: got {body!r}, expected {base!r} (frames.base)",
            place_in(self._links, base, body),
        )
        if place is None:
            is_floor = body.strip("/").rpartition("/")[::2] == (base.strip("/").rpartition("/")[0], ON_THE_FLOOR)
            remedy = "give frames.base, or the body's place (mocap.body_offset_x, _y, _yaw)"
            return "" if is_floor else f"{said}; nothing on /tf_static joins them: {remedy}"
        (x, y, _), yaw = place[0].tolist(), math.atan2(*place[1].as_matrix()[1::-1, 0])
        if math.hypot(x, y) < NEAR and abs(yaw) < ALIGNED:
            return ""
        return f"{said}; by /tf_static it is at mocap.body_offset_x {x:.3f}, _y {y:.3f}, _yaw {yaw:.3f}: set these"
