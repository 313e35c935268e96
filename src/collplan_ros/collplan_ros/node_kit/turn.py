"""A node's reports to a simulation that waits for its graph: the time up to which the node has done its work."""

import math
from collections.abc import Callable

from rclpy.clock import Clock, ROSClock
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.time import Time
from sensor_msgs.msg import TimeReference

from collplan_ros.messages.qos import EVENT
from collplan_ros.node_kit.clock import steady_clock

TOPIC = "lockstep"
STEP = 0.015
"""Shortest simulated time between two reports [s]."""
IDLE_PERIOD = 0.05
"""Time after which a node that acts on messages reports without one [s]: one that was lost must not be waited for."""
END = 2**31 - 1
"""The time reported by a node that ends [s]: nothing is due of it any more."""


class Turn:
    """Publishes on `lockstep` where the node follows /clock: nothing is due of it, `source`, before `time_ref`.

    Without /clock it publishes nothing, as nobody waits then.
    """

    def __init__(self, node: Node, clock: Clock, time_left: Callable[[], float] | None = None) -> None:
        """Reports of `node`, whose time is `clock`.

        `time_left` says for how long nothing is due [s]; without it the node acts on messages alone.
        """
        self._clock = clock
        self._time_left = time_left
        self._name = node.get_fully_qualified_name()
        self._reported = -math.inf
        is_awaited = isinstance(clock, ROSClock) and clock.ros_time_is_active
        self._out: Publisher | None = None
        if is_awaited:
            self._out = node.create_publisher(TimeReference, TOPIC, EVENT)
            if time_left is None:
                node.create_timer(IDLE_PERIOD, self.over, clock=steady_clock())

    def over(self, now: float | None = None) -> None:
        """Reports that all work due by now is done, and, where the node knows it, when the next is due.

        `now` is the time at which it was done [s], where another thread may have advanced the clock since.
        """
        if self._out is None:
            return
        until = self._clock.now().nanoseconds if now is None else round(1e9 * now)
        if self._time_left is not None:
            until += round(1e9 * self._time_left())
        if 1e-9 * until >= self._reported + STEP:
            self._report(until)

    def end(self) -> None:
        """Reports that nothing is due of the node until it reports again."""
        self._report(END * 10**9)
        self._reported = -math.inf

    def _report(self, until: int) -> None:
        if self._out is None:
            return
        self._reported = 1e-9 * until
        message = TimeReference(source=self._name, time_ref=Time(nanoseconds=until).to_msg())
        message.header.stamp = self._clock.now().to_msg()
        self._out.publish(message)
