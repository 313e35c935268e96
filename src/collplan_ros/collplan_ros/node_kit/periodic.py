"""Timers for what a node does each period of its local clock."""

from collections.abc import Callable

from rclpy.clock import Clock
from rclpy.node import Node
from rclpy.timer import Timer


def call_each_period(node: Node, period: float, act: Callable[[], None], clock: Clock) -> Timer:
    """A timer of `node` that calls `act` each `period` [s] of `clock`, and never twice for one period.

    EventsExecutor (rclpy 7.1.6) calls a timer twice where /clock comes again before it was called, and then not in the
    next period.
    """

    def tick() -> None:
        if timer.time_until_next_call() > timer.timer_period_ns:
            timer.reset()
        else:
            act()

    timer = node.create_timer(period, tick, clock=clock)
    return timer
