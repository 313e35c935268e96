"""The topics of a run that are recorded, and which of them the page shows: the messages of each and their QoS.

planner/markers are not: they show what the clouds hold, are made only for subscribers, and take as long as a plan.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module

from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PointStamped, PoseStamped, Vector3Stamped
from nav_msgs.msg import Odometry, Path
from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan, PointCloud2
from std_msgs.msg import Empty, Float64, String
from visualization_msgs.msg import MarkerArray

from collplan_core.parameters import Settings
from collplan_core.parameters.spec import ParameterError
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import command_type
from collplan_ros.messages.mocap_formats import message_type

TOPICS: dict[str, tuple[type, QoSProfile, QoSProfile | None]] = {
    "goal_pose": (PoseStamped, qos.EVERY_ONE, qos.EVENT),
    "mocap/odom": (Odometry, qos.EVERY_ONE, qos.POSES_SHOWN),
    "mocap/refused": (String, qos.EVERY_ONE, None),
    "impact": (Vector3Stamped, qos.EVERY_ONE, None),
    "impact/contact": (PointCloud2, qos.EVERY_ONE, qos.EVENT),
    "plan": (Path, qos.EVERY_ONE, qos.NEWEST_SHOWN),
    "planner/trajectory": (PointCloud2, qos.EVERY_ONE, qos.EVENT),
    "planner/heartbeat": (Empty, qos.EVERY_ONE, None),
    "planner/costs": (DiagnosticArray, qos.EVERY_ONE, qos.NEWEST_SHOWN),
    "planner/seen": (PointCloud2, qos.EVERY_ONE, qos.LATCHED),
    "planner/compared": (PointCloud2, qos.EVERY_ONE, qos.LATCHED),
    "movers": (MarkerArray, qos.EVERY_ONE, qos.NEWEST_SHOWN),
    "controller/reference": (PointStamped, qos.EVERY_ONE, None),
    "robot/resumed": (Empty, qos.EVERY_ONE, None),
    "ground_truth/odom": (Odometry, qos.EVERY_ONE, None),
    "ground_truth/impact": (Vector3Stamped, qos.EVERY_ONE, None),
    "ground_truth/impact/contact": (PointCloud2, qos.EVERY_ONE, None),
    "ground_truth/movers": (MarkerArray, qos.EVERY_ONE, qos.NEWEST_SHOWN),
    "/parameter_events": (ParameterEvent, qos.EVERY_ONE, None),
    "planner/journal": (String, qos.EVERY_LATCHED, None),
    "controller/journal": (String, qos.EVERY_LATCHED, None),
    "goal_status": (GoalStatus, qos.EVERY_LATCHED, qos.LATCHED),
    "maneuver": (String, qos.EVERY_LATCHED, None),
    "controller/state": (DiagnosticStatus, qos.EVERY_LATCHED, qos.LATCHED),
    "controller/motion_delay": (Float64, qos.EVERY_LATCHED, None),
    "controller/drive": (DiagnosticStatus, qos.EVERY_LATCHED, qos.LATCHED),
    "robot/state": (DiagnosticStatus, qos.EVERY_LATCHED, qos.LATCHED),
    "shared_constants": (DiagnosticStatus, qos.EVERY_LATCHED, qos.CONSTANTS_SUBSCRIBED),
    "/diagnostics": (DiagnosticArray, qos.EVERY_LATCHED, qos.DIAGNOSTICS_SUBSCRIBED),
    "/rosout": (Log, qos.EVERY_LATCHED, None),
}
"""Messages of each topic, and its profiles for the recording and, where the page shows it, for that."""


@dataclass(frozen=True)
class RecordedTopic:
    """A topic that is recorded."""

    name: str  # as its nodes use it: within the robot's namespace, but for those that begin with a slash
    kind: type
    qos: QoSProfile  # matches every publisher of it and leaves no message out
    shown: QoSProfile | None = None  # by which the page subscribes to it; None where it does not show it


def recorded_topics(settings: Settings, real_scans: bool = False) -> dict[str, RecordedTopic]:
    """Every topic that is recorded of a robot with these parameters, by its name.

    `real_scans`: whether a LIDAR's driver sends them, which may do so best effort; lidar_node does not.
    """
    scans = RecordedTopic("scan", LaserScan, qos.EVERY_UNRELIABLE if real_scans else qos.EVERY_ONE, qos.NEWEST_SHOWN)
    return {topic.name: topic for topic in (scans, *_topics(settings))}


def _topics(settings: Settings) -> Iterator[RecordedTopic]:
    mocap = settings.mocap
    try:
        measured = qos.EVERY_ONE if mocap.reliability == "reliable" else qos.EVERY_UNRELIABLE
        yield RecordedTopic(mocap.topic, message_type(mocap), measured)
    except ParameterError:  # mocap_node reports this, and ends
        pass
    command = command_type(settings.controller)
    yield RecordedTopic("cmd_vel", command, qos.EVERY_ONE, qos.COMMANDS_SHOWN)
    yield RecordedTopic("hand/cmd_vel", command, qos.EVERY_ONE)
    if settings.simulator.publishes_clock:
        yield RecordedTopic("/clock", Clock, qos.EVERY_ONE)
    try:
        transforms = import_module("tf2_msgs.msg").TFMessage
        yield RecordedTopic("/tf", transforms, qos.EVERY_ONE)
        yield RecordedTopic("/tf_static", transforms, qos.EVERY_LATCHED)
    except ImportError:  # is not among the pip packages, and then nobody sends any
        pass
    for name, (kind, recorded, shown) in TOPICS.items():
        yield RecordedTopic(name, kind, recorded, shown)
