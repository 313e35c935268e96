"""The LIDAR's place on a robot that is not simulated, from the static transforms of the robot's description."""

import math
import os
import time
from contextlib import ExitStack
from dataclasses import replace
from functools import partial

from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import LaserScan

from collplan_core.calibration.frame_chain import LidarMount, Link, mount_in
from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.network import environment_set, graph_environment
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.messages.qos import LATCHED_TRANSFORMS, SENSOR_DATA
from collplan_ros.nodes.odometry_body import take_links

PATIENCE = 3.0
"""Longest wait for scans and transforms [s]."""
LOOK_PERIOD = 0.05
"""Period at which what came is looked at [s]."""


def with_lidar_place(preparation: Preparation) -> tuple[Preparation, str]:
    """The preparation with the LIDAR where /tf_static says, unless parameters say it, and how that went, in words.

    Raises:
        StartError: the LIDAR is not level.
    """
    if not preparation.lidar_unsaid:
        return preparation, ""
    try:
        base, frame, mount = preparation.settings.frames.base, *_listened(preparation)
    except ValueError as error:
        raise StartError(f"/tf_static: {error}") from None
    if mount is None:
        return preparation, (
            f"LIDAR: taken to be at the robot's centre, facing forward. /tf_static has no transform from {base} to "
            f"{frame or 'the frame of the scans, none of which came'}: scan.offset_x, _y and _yaw can say it"
        )
    found = {f"scan.offset_{key}": getattr(mount, key) for key in ("x", "y", "yaw")}
    values = {**found, "scan.mirrored": mount.mirrored, "scan.frame": "" if frame == base else frame}
    upside_down = ", upside down" if mount.mirrored else ""
    place = f"{mount.x:.3f} m forward, {mount.y:.3f} m left, turned by {math.degrees(mount.yaw):.1f} degrees"
    said = f"LIDAR: {frame} is {place}{upside_down}: /tf_static"
    return replace(preparation, settings=preparation.settings.with_values(values)), said


def _listened(preparation: Preparation) -> tuple[str, LidarMount | None]:
    """Frame of the scans, "" where none came, and its place, None where /tf_static does not join it to the robot."""
    try:
        from tf2_msgs.msg import TFMessage
    except ImportError:
        return preparation.settings.scan.frame, None
    links: dict[str, Link] = {}
    frames, base = [preparation.settings.scan.frame], preparation.settings.frames.base

    def take_scan(message: LaserScan) -> None:
        frames[0] = frames[0] or str(message.header.frame_id)

    with ExitStack() as stack:
        stack.enter_context(environment_set(graph_environment(preparation.network, os.environ)))
        context = Context()
        stack.callback(context.try_shutdown)
        arguments = ["--ros-args", *preparation.remapped]
        try:
            context.init(args=[])
            node = Node("lidar_place", context=context, namespace=preparation.namespace, cli_args=arguments)
        except RuntimeError:  # ROS does not start: bringup's own node says why
            return frames[0], None
        stack.callback(node.destroy_node)
        node.create_subscription(TFMessage, "/tf_static", partial(take_links, links), LATCHED_TRANSFORMS)
        node.create_subscription(LaserScan, "scan", take_scan, SENSOR_DATA)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        stack.callback(executor.shutdown)
        end = time.monotonic() + PATIENCE
        while (mount := mount_in(links, base, frames[0])) is None and time.monotonic() < end:
            executor.spin_once(LOOK_PERIOD)
    return frames[0], mount
