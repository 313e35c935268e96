"""Subscriptions of planner and controller to poses and scans."""

from collections.abc import Callable

from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from collplan_core.parameters import Settings
from collplan_core.scan import Scan, ScanError
from collplan_core.state import State
from collplan_ros.messages import qos
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.reading import MessageError, scan_from_message, suspiciously_near
from collplan_ros.node_kit.inputs import Inputs


def listen_to_sensors(
    inputs: Inputs,
    refuse: Callable[[str, str], None],
    take_pose: Callable[[State], None],
    take_scan: Callable[[Scan], None],
    settings: Settings,
) -> None:
    """Subscribes mocap/odom and scan; unusable ones go to `refuse` as "pose" or "scan", with the reason."""
    frames = settings.frames

    def on_pose(raw: bytes) -> None:
        try:
            state = state_from_bytes(raw, frames.map, frames.base)
        except MessageError as error:
            refuse("pose", str(error))
            raise
        take_pose(state)

    def on_scan(message: LaserScan) -> None:
        try:
            scan = scan_from_message(message, frames.base, settings.scan)
        except ScanError as error:
            refuse("scan", str(error))
            raise
        inputs.hint("scan", suspiciously_near(message, settings.scan))
        take_scan(scan)

    inputs.listen(Odometry, "mocap/odom", on_pose, qos.POSE_SUBSCRIBED, kind="pose", raw=True)
    inputs.listen(LaserScan, "scan", on_scan, qos.SENSOR_DATA, kind="scan")
