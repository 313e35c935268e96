"""Subscriptions of view_node: those of a drawn graph, from when a page is opened until none is."""

from collections.abc import Callable, Mapping
from typing import Any

from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import LaserScan, PointCloud2
from visualization_msgs.msg import MarkerArray

from collplan_core.parameters import Settings
from collplan_ros.messages import qos
from collplan_ros.messages.conversions import command_type
from collplan_ros.messages.raw_reading import BYTES_TOPICS
from collplan_ros.node_kit.node_names import is_in
from collplan_ros.node_kit.shown_topics import ShownTopics
from collplan_ros.nodes.view_parameters import GraphParameters
from collplan_ros.view.drawn_graph import DrawnGraph

POSES = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
"""Every pose of a frame's time and of a short stall; none is waited for."""
COMMANDS = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=20, reliability=ReliabilityPolicy.BEST_EFFORT)
NEWEST = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
GOAL = "goal_pose"
TOPICS: dict[str, tuple[type, QoSProfile]] = {
    "mocap/odom": (Odometry, POSES),
    "scan": (LaserScan, NEWEST),
    "planner/trajectory": (PointCloud2, qos.EVENT),
    "plan": (Path, NEWEST),
    "planner/seen": (PointCloud2, qos.LATCHED),
    "planner/compared": (PointCloud2, qos.LATCHED),
    "planner/costs": (DiagnosticArray, NEWEST),
    "goal_status": (GoalStatus, qos.LATCHED),
    "ground_truth/movers": (MarkerArray, NEWEST),
    "movers": (MarkerArray, NEWEST),
    "impact/contact": (PointCloud2, qos.EVENT),
    "controller/state": (DiagnosticStatus, qos.LATCHED),
    "controller/drive": (DiagnosticStatus, qos.LATCHED),
    "robot/state": (DiagnosticStatus, qos.LATCHED),
    "/diagnostics": (DiagnosticArray, qos.DIAGNOSTICS_SUBSCRIBED),
}
"""Type and QoS of each topic, but for the commands, whose type is a parameter."""


class ViewInputs:
    """The topics that the page shows: subscribed between `open` and `close`.

    Attributes:
        graph: the graph as it is drawn.
    """

    def __init__(
        self, node: Node, settings: Settings, parameters: GraphParameters, new_graph: Callable[[], DrawnGraph]
    ) -> None:
        """Subscribes in `node`; an opening begins with a `new_graph`. `parameters` takes what nodes tell."""
        self.graph = new_graph()
        self._new_graph = new_graph
        self._parameters = parameters
        self._namespace = node.get_namespace()
        self._topics = TOPICS | {"cmd_vel": (command_type(settings.controller), COMMANDS)}
        # a goal is not repeated
        self._always = ShownTopics(node)
        self._always.listen(PoseStamped, GOAL, self._take_goal, qos.EVENT)
        self._watched = ShownTopics(node)

    @property
    def refused(self) -> int:
        """Number of messages that could not be read."""
        return self._always.refused + self._watched.refused

    @property
    def newest_refusal(self) -> str:
        """Text of the newest message that could not be read; "" before the first."""
        return self._watched.newest_refusal or self._always.newest_refusal

    def open(self) -> None:
        """Subscribes to everything that is shown."""
        self._begin_anew()
        for topic, (kind, profile) in self._topics.items():
            self._watched.listen(kind, topic, self._taker(topic), profile, raw=topic in BYTES_TOPICS)
        self._watched.listen(DiagnosticStatus, "shared_constants", self._take_constants, qos.CONSTANTS_SUBSCRIBED)
        self.graph.put_goal()

    def close(self) -> None:
        """Ends what `open` began."""
        self._watched.close()
        self._begin_anew()

    def _begin_anew(self) -> None:
        goal, self.graph = self.graph.goal, self._new_graph()
        self.graph.goal = goal

    def _taker(self, topic: str) -> Callable[[Any, Mapping[str, Any]], None]:
        take = self.graph.takers[topic]
        return lambda message, info: take(message, 1e-9 * info["source_timestamp"])

    def _take_goal(self, message: PoseStamped, _: Mapping[str, Any]) -> None:
        self.graph.takers[GOAL](message, 0.0)

    def _take_constants(self, message: DiagnosticStatus, _: Mapping[str, Any]) -> None:
        if is_in(self._namespace, str(message.name)):
            self._parameters.take(message)
