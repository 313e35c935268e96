"""Health reports of a node: one status on /diagnostics, once a second."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from collplan_ros.messages.qos import DIAGNOSTICS_PUBLISHED
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
        message = DiagnosticArray(status=[status_message(self._node.get_fully_qualified_name(), self._report())])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)


def status_message(name: str, health: Health) -> DiagnosticStatus:
    """The status message of a node's health, with floats printed to six digits."""
    values = [KeyValue(key=str(key), value=_printed(value)) for key, value in health.values.items()]
    return DiagnosticStatus(level=health.level, name=name, message=health.message, values=values)


def _printed(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
