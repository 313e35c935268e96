"""Health reports of a node: one status on /diagnostics, once a second."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node

from collplan_ros.messages.qos import DIAGNOSTICS_PUBLISHED
from collplan_ros.messages.states import status_message
from collplan_ros.node_kit.clock import steady_clock

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR


@dataclass(frozen=True)
class Health:
    """Health of a node: level (OK, WARN, ERROR), one line of text, and figures by name."""

    level: bytes
    message: str
    values: Mapping[str, object] = field(default_factory=dict)

    @staticmethod
    def of(values: Mapping[str, object], well: str, *troubles: tuple[bytes, str]) -> "Health":
        """The health of a node with these figures: the first of its troubles that has words, or `well`."""
        level, words = next((trouble for trouble in troubles if trouble[1]), (OK, well))
        return Health(level, words, values)

    def with_inputs(self, refusals: Mapping[str, object], conflicts: Sequence[str], disagreement: str) -> "Health":
        """The health with what was refused, and at least a warning while inputs are in conflict or constants differ."""
        own = disagreement if self.level == OK else self.message
        values = {**self.values, **refusals}
        if not conflicts and not own:
            return replace(self, values=values)
        return Health(max(self.level, WARN), "; ".join(filter(None, [*conflicts, own])), values)


class Diagnostics:
    """Publishes the health that `report()` returns at 1 Hz, for the first time when constructed.

    Construct it last in a node: the first message means that the node is ready.
    """

    def __init__(self, node: Node, report: Callable[[], Health]) -> None:
        self._node = node
        self._report = report
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", DIAGNOSTICS_PUBLISHED)
        # steady even where the node follows /clock: a stalled simulation must still be reported
        self._timer = node.create_timer(1.0, self.publish, clock=steady_clock())
        self.publish()

    def publish(self) -> None:
        """Publishes the present health at once."""
        name, health = self._node.get_fully_qualified_name(), self._report()
        message = DiagnosticArray(status=[status_message(name, health.level, health.message, health.values)])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
