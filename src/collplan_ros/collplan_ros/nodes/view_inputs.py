"""Subscriptions of view_node: those of a drawn graph, from when a page is opened until none is."""

from ast import literal_eval
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from collplan_core.parameters import Settings
from collplan_ros.messages import qos
from collplan_ros.messages.raw_reading import BYTES_TOPICS
from collplan_ros.messages.status_values import values_of
from collplan_ros.node_kit.inputs import Info, with_info
from collplan_ros.node_kit.node_names import is_in
from collplan_ros.run.topics import recorded_topics
from collplan_ros.view.drawn_graph import DrawnGraph


def _best_effort(depth: int) -> QoSProfile:
    return QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=depth, reliability=ReliabilityPolicy.BEST_EFFORT)


GOAL, CONSTANTS = "goal_pose", "shared_constants"
SHOWN: dict[str, QoSProfile] = {
    # every pose of a frame's time and of a short stall; none is waited for
    "mocap/odom": _best_effort(100),
    "cmd_vel": _best_effort(20),
    **dict.fromkeys(("scan", "plan", "planner/costs", "ground_truth/movers", "movers"), _best_effort(1)),
    **dict.fromkeys(("planner/trajectory", "impact/contact"), qos.EVENT),
    **dict.fromkeys(("planner/seen", "planner/compared", "goal_status"), qos.LATCHED),
    **dict.fromkeys(("controller/state", "controller/drive", "robot/state"), qos.LATCHED),
    "/diagnostics": qos.DIAGNOSTICS_SUBSCRIBED,
    CONSTANTS: qos.CONSTANTS_SUBSCRIBED,
}
"""Profiles of what is subscribed while a page is open; the types are those of `recorded_topics`."""


class ViewInputs:
    """The topics that the page shows: subscribed between `open` and `close`, but for goals, which are not repeated."""

    def __init__(self, node: Node, settings: Settings, new_graph: Callable[[], DrawnGraph]) -> None:
        """Subscribes in `node`; an opening begins with a `new_graph`."""
        self.graph = new_graph()
        """The graph as it is drawn."""
        self.parameters: dict[str, dict[str, object]] = {}
        """What nodes tell of theirs, latched and whenever one changes: by node, the newest told last, and by name."""
        self.refused = 0
        """Number of messages that could not be read."""
        self.newest_refusal = ""
        """Reason of the newest one; empty before the first."""
        self._node = node
        self._new_graph = new_graph
        self._topics = recorded_topics(settings)
        self._goals = self._subscribed(GOAL, qos.EVENT)
        self._watched: list[Subscription] = []

    def open(self) -> None:
        """Subscribes to everything that is shown."""
        self._begin_anew()
        self._watched = [self._subscribed(topic, profile) for topic, profile in SHOWN.items()]
        self.graph.put_goal()

    def close(self) -> None:
        """Ends what `open` began."""
        for subscription in self._watched:
            self._node.destroy_subscription(subscription)
        self._watched = []
        self._begin_anew()

    def _begin_anew(self) -> None:
        goal, self.graph = self.graph.goal, self._new_graph()
        self.graph.goal = goal

    def _subscribed(self, topic: str, profile: QoSProfile) -> Subscription:
        kind = self._topics[topic].kind

        def taking(data: bytes, info: Info) -> None:
            if subscription is not self._goals and subscription not in self._watched:
                return  # it came while all ended
            # a message of another program may be wrong in any way, and must not end a viewer
            try:
                message = data if topic in BYTES_TOPICS else deserialize_message(data, kind)
                if topic == CONSTANTS:
                    self._take_constants(message)
                else:
                    self.graph.takers[topic](message, 1e-9 * info["source_timestamp"])
            except Exception as error:
                self.refused += 1
                self.newest_refusal = f"{subscription.topic}: {' '.join(str(error).split())}"

        # as bytes: an executor that cannot read a message raises
        subscription = self._node.create_subscription(kind, topic, with_info(taking), profile, raw=True)
        return subscription

    def _take_constants(self, message: Any) -> None:
        """Takes what a node tells; a value that is none of Python's is left out."""
        name, told = str(message.name), dict[str, object]()
        if not is_in(self._node.get_namespace(), name):
            return
        for key, text in values_of(message).items():
            with suppress(ValueError, SyntaxError):
                told[key] = literal_eval(text)
        self.parameters.pop(name, None)
        self.parameters[name] = told
