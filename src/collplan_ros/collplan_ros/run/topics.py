"""The topics of a run that are recorded: the messages of each and their QoS.

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
from collplan_ros.messages.conversions import command_type
from collplan_ros.messages.mocap_formats import message_type
from collplan_ros.messages.qos import EVERY_LATCHED, EVERY_ONE, EVERY_UNRELIABLE

RELIABLE: dict[str, type] = {
    "goal_pose": PoseStamped,
    "mocap/odom": Odometry,
    "mocap/refused": String,
    "impact": Vector3Stamped,
    "impact/contact": PointCloud2,
    "plan": Path,
    "planner/trajectory": PointCloud2,
    "planner/heartbeat": Empty,
    "planner/costs": DiagnosticArray,
    "planner/seen": PointCloud2,
    "planner/compared": PointCloud2,
    "movers": MarkerArray,
    "controller/reference": PointStamped,
    "robot/resumed": Empty,
    "ground_truth/odom": Odometry,
    "ground_truth/impact": Vector3Stamped,
    "ground_truth/impact/contact": PointCloud2,
    "ground_truth/movers": MarkerArray,
    "/parameter_events": ParameterEvent,
}
LATCHED: dict[str, type] = {
    "planner/journal": String,
    "controller/journal": String,
    "goal_status": GoalStatus,
    "maneuver": String,
    "controller/state": DiagnosticStatus,
    "controller/motion_delay": Float64,
    "controller/drive": DiagnosticStatus,
    "robot/state": DiagnosticStatus,
    "shared_constants": DiagnosticStatus,
    "/diagnostics": DiagnosticArray,
    "/rosout": Log,
}


@dataclass(frozen=True)
class RecordedTopic:
    """A topic that is recorded."""

    name: str  # as its nodes use it: within the robot's namespace, but for those that begin with a slash
    kind: type
    qos: QoSProfile  # matches every publisher of it and leaves no message out


def recorded_topics(settings: Settings, real_scans: bool = False) -> dict[str, RecordedTopic]:
    """Every topic that is recorded of a robot with these parameters, by its name.

    `real_scans`: whether a LIDAR's driver sends them, which may do so best effort; lidar_node does not.
    """
    scans = RecordedTopic("scan", LaserScan, EVERY_UNRELIABLE if real_scans else EVERY_ONE)
    return {topic.name: topic for topic in (scans, *_topics(settings))}


def _topics(settings: Settings) -> Iterator[RecordedTopic]:
    mocap = settings.mocap
    try:
        measured = EVERY_ONE if mocap.reliability == "reliable" else EVERY_UNRELIABLE
        yield RecordedTopic(mocap.topic, message_type(mocap), measured)
    except ParameterError:  # mocap_node reports this, and ends
        pass
    for name in ("cmd_vel", "hand/cmd_vel"):
        yield RecordedTopic(name, command_type(settings.controller), EVERY_ONE)
    if settings.simulator.publishes_clock:
        yield RecordedTopic("/clock", Clock, EVERY_ONE)
    try:
        transforms = import_module("tf2_msgs.msg").TFMessage
        yield RecordedTopic("/tf", transforms, EVERY_ONE)
        yield RecordedTopic("/tf_static", transforms, EVERY_LATCHED)
    except ImportError:  # is not among the pip packages, and then nobody sends any
        pass
    for kinds, qos in ((RELIABLE, EVERY_ONE), (LATCHED, EVERY_LATCHED)):
        for name, kind in kinds.items():
            yield RecordedTopic(name, kind, qos)
