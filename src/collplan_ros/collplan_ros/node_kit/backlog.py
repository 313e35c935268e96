"""Backlog in a node's subscriptions from while the node was frozen: it is dropped, as it would be taken for new."""

from threading import Lock
from time import monotonic

from rclpy.node import Node
from rclpy.subscription import Subscription

from collplan_core.ages import StallGuard
from collplan_ros.node_kit.clock import follows_clock, steady_clock

TICK_PERIOD = 0.05
"""Period of the steady timer [s]."""


class Backlog:
    """Drops the queues of a node's subscriptions after a gap in its steady timer; no queue where it follows /clock.

    A node whose callbacks take long has another thread `tick`: then only a process that does not run at all has a gap.
    """

    def __init__(self, node: Node) -> None:
        """Makes the timer in `node`."""
        self.guard = StallGuard()  # the gaps so far
        self._log = node.get_logger()
        self._subscriptions: list[Subscription] = []
        self._due = False
        self._lock = Lock()
        self._drops = not follows_clock(node)
        node.create_timer(TICK_PERIOD, self._drop, clock=steady_clock())

    def watch(self, subscription: Subscription) -> None:
        """Has the queue of a subscription dropped from now on."""
        self._subscriptions.append(subscription)

    def tick(self) -> None:
        """Registers that the process runs; may be called from any thread."""
        with self._lock:
            self._due = self.guard.tick(monotonic()) or self._due

    def holds(self) -> bool:
        """Returns whether this callback's message queued up in a gap; the rest of the queues is then dropped too."""
        return self._drop()

    def _drop(self) -> bool:
        self.tick()
        with self._lock:
            due, self._due = self._due and self._drops, False
        if due:
            dropped = sum(map(_emptied, self._subscriptions))
            self._log.warning(f"did not run for {self.guard.gap:.2f} s: {dropped} messages that queued up are dropped")
        return due


def _emptied(subscription: Subscription) -> int:
    """Empties a subscription's queue; returns the number of messages, at most the depth of the queue."""
    with subscription.handle:
        for count in range(subscription.qos_profile.depth):
            if subscription.handle.take_message(subscription.msg_type, subscription.raw) is None:
                return count
    return int(subscription.qos_profile.depth)
