"""Subscriptions of planner and controller to poses and scans."""

from collections.abc import Callable

from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.replay.journal import Journal
from collplan_core.scan import ScanError
from collplan_core.state import State
from collplan_ros.messages import qos
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.reading import MessageError, scan_from_message, suspiciously_near
from collplan_ros.node_kit.inputs import Inputs


def listen_to_sensors(
    inputs: Inputs,
    journal: Journal,
    loop: PlannerLoop | ControllerLoop,
    take_pose: Callable[[State], None],
    local: Callable[[], float],
    settings: Settings,
) -> None:
    """Subscribes mocap/odom and scan, and hands them to `loop` at a `local` time [s], also why one is unusable.

    Poses go to `take_pose`, as a loop may decide at one.
    """
    frames = settings.frames

    def refuse(kind: str, reason: str) -> None:
        journal.call(loop.refuse, kind, reason)

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
        journal.call(loop.take_scan, scan, local())

    inputs.listen(Odometry, "mocap/odom", on_pose, qos.POSE_SUBSCRIBED, kind="pose", raw=True)
    inputs.listen(LaserScan, "scan", on_scan, qos.SENSOR_DATA, kind="scan")
