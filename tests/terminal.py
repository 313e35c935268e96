"""What nodes write to the terminal."""

from rcl_interfaces.msg import Log
from rclpy.impl.logging_severity import LoggingSeverity

from collplan_ros.messages.qos import DIAGNOSTICS_SUBSCRIBED

INFO, WARN, ERROR = LoggingSeverity.INFO, LoggingSeverity.WARN, LoggingSeverity.ERROR


class Terminal:
    """The lines of every node of a graph; make it before the nodes."""

    def __init__(self, ros) -> None:
        ros.forget_others()
        self._ros = ros
        self._logs = ros.listen(Log, "/rosout", DIAGNOSTICS_SUBSCRIBED)

    def lines(self, node) -> list[tuple[int, str]]:
        return [(log.level, log.msg) for log in self._logs if log.name == node.get_logger().name]

    def says(self, node, level: int, text: str, timeout: float = 20.0) -> None:
        assert self._ros.wait_until(lambda: (level, text) in self.lines(node), timeout), (
            f"{text!r} not in {self.lines(node)}"
        )

    def has(self, node, words: str, times: int = 1, timeout: float = 20.0) -> bool:
        """Waits for so many lines of a node that hold these words; whether they came."""
        return self._ros.wait_until(lambda: sum(words in text for _, text in self.lines(node)) >= times, timeout)
