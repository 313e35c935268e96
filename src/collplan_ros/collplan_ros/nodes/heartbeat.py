"""The planner's heartbeat: it goes on while a plan takes long, and ends with the process or where that is frozen."""

from collections.abc import Callable
from threading import Event, Thread
from time import monotonic

from rclpy.node import Node
from std_msgs.msg import Empty

from collplan_ros.messages import qos
from collplan_ros.node_kit.clock import call_each_period, follows_clock, local_clock

TOPIC = "planner/heartbeat"
BEAT_PERIOD = 0.05
"""Between two beats [s]."""


class Heartbeat:
    """Publishes an empty message each BEAT_PERIOD until `end`, from a thread of its own.

    Where the node follows /clock there is none: simulated time stands still while a plan is made.
    """

    def __init__(self, node: Node, at_each: Callable[[], None]) -> None:
        """Publishes through `node`, and calls `at_each` in that thread at each beat."""
        self._publisher = node.create_publisher(Empty, TOPIC, qos.NEWEST)
        self._at_each = at_each
        self._ended = Event()
        self._thread = Thread(target=self._beat, name="heartbeat", daemon=True)
        if follows_clock(node):
            call_each_period(node, BEAT_PERIOD, lambda: self._publisher.publish(Empty()), local_clock(node))
        else:
            self._thread.start()

    def end(self) -> None:
        """Ends it, before the node is destroyed; a second call does nothing."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def _beat(self) -> None:
        due = monotonic()
        while not self._ended.is_set():
            self._at_each()
            try:
                self._publisher.publish(Empty())
            except RuntimeError:  # rcl's own errors: the node or its context has ended before
                return
            # by the clock, not by the time since the last one; none is made up for
            due = max(due + BEAT_PERIOD, monotonic())
            self._ended.wait(due - monotonic())
