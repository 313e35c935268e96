"""Constants that all nodes of a graph must share: each publishes its own, planner and controller compare them."""

from collections import Counter
from collections.abc import Mapping

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from collplan_core.parameters import Settings
from collplan_ros.messages.qos import CONSTANTS_PUBLISHED, CONSTANTS_SUBSCRIBED
from collplan_ros.messages.states import status_message
from collplan_ros.messages.status_values import values_of
from collplan_ros.node_kit.clock import steady_clock
from collplan_ros.node_kit.node_parameters import Group, on_change, specs_of
from collplan_ros.node_kit.publishers import UNKNOWN, listed_publishers

CHECK_PERIOD = 1.0
"""Time between two looks at which nodes are still there [s]."""
ABSENT_LOOKS = 3
"""Looks in a row at which a node is not there until it counts as ended: its message may come before ROS lists it."""
GROUPS = ("robot.", "frames.", "limits.fence", "scan.")
"""Beginnings of the keys of constants that must be shared."""
SHOWN = ("simulator.world", "lidar.world", "planner.strategy", "driver.port", "emulator.link")
"""Keys told beside them, for the page: the world, the strategy, and whether the robot is real; they may differ."""


def constants_of(settings: Settings, *groups: Group) -> dict[str, str]:
    """Returns the constants of these groups that all nodes must share, by key, as Python prints them; none is live."""
    values = settings.values()
    keys = [spec.key for spec in specs_of(groups) if spec.key.startswith(GROUPS) and not spec.live]
    return {key: repr(values[key]) for key in sorted(keys)}


def disagreement(ours: Mapping[str, str], others: Mapping[str, Mapping[str, str]]) -> str:
    """Where constants of this and other nodes, by name, differ, over the keys that both have; "" where they agree.

    For each key "robot.radius: 0.09 here, 0.15 in /driver_node", by key, then by value, joined with "; ".
    """
    found: dict[tuple[str, str], list[str]] = {}
    for name, theirs in others.items():
        for key in ours.keys() & theirs.keys():
            if theirs[key] != ours[key]:
                found.setdefault((key, theirs[key]), []).append(name)
    return "; ".join(
        f"{key}: {ours[key]} here, {value} in {', '.join(sorted(names))}"
        for (key, value), names in sorted(found.items())
    )


class SharedConstants:
    """Publishes a node's constants to the others in its namespace; `compare` holds them against theirs.

    A node that has ended no longer disagrees, nor does one that has started again with other values. A node that must
    stand still on a disagreement reads `disagreement` at each step.
    """

    def __init__(self, node: Node, settings: Settings, *groups: Group) -> None:
        """Publishes the constants of these groups, declared by `node`, that all must share."""
        self.disagreement = ""  # the differences, as the function `disagreement` returns them
        self._node = node
        self._name = node.get_fully_qualified_name()
        self._ours = constants_of(settings, *groups)
        self._others: dict[str, Mapping[str, str]] = {}
        self._absences: Counter[str] = Counter()
        self._logged = ""
        self._shown = [spec.key for spec in specs_of(groups) if spec.key in SHOWN]
        self._publisher = node.create_publisher(DiagnosticStatus, "shared_constants", CONSTANTS_PUBLISHED)
        on_change(node, self._tell, *groups)
        self._tell(settings)

    def compare(self) -> None:
        """Logs an error whenever a disagreement begins from now on, and a line of information when it ends."""
        self._node.create_subscription(DiagnosticStatus, "shared_constants", self._take, CONSTANTS_SUBSCRIBED)
        # steady even where the node follows /clock: a clock that stands still must not hide who has ended
        self._node.create_timer(CHECK_PERIOD, self._check, clock=steady_clock())

    def _tell(self, settings: Settings) -> None:
        values = settings.values()
        told = {**self._ours, **{key: repr(values[key]) for key in self._shown}}
        self._publisher.publish(status_message(self._name, DiagnosticStatus.OK, "", told))

    def _take(self, message: DiagnosticStatus) -> None:
        if message.name == self._name:
            return
        self._others[message.name] = values_of(message)
        self.disagreement = disagreement(self._ours, self._others)

    def _check(self) -> None:
        if self.disagreement:  # whether nodes that agree are still there makes no difference
            self._drop_ended()
            self.disagreement = disagreement(self._ours, self._others)
        before, self._logged = self._logged, self.disagreement
        if before and not self.disagreement:
            self._node.get_logger().info("nodes agree again")
        elif self.disagreement != before:
            self._node.get_logger().error(f"nodes disagree: {self.disagreement}; these must be the same in all")

    def _drop_ended(self) -> None:
        running = listed_publishers(self._node, self._publisher.topic_name)
        if UNKNOWN in running:
            return  # one that is not yet discovered whole may be any of them
        self._absences = Counter({name: self._absences[name] + 1 for name in self._others if name not in running})
        self._others = {name: theirs for name, theirs in self._others.items() if self._absences[name] < ABSENT_LOOKS}
