"""The local clock of a node, for ages and timers."""

from rclpy.clock import Clock, ClockType
from rclpy.node import Node


def local_clock(node: Node) -> Clock:
    """The clock for a node's timers and ages: the steady clock, or the node's own where it follows /clock.

    System time is unsuitable: it steps when it is synchronised, and timers on it then stall.
    """
    return node.get_clock() if follows_clock(node) else steady_clock()


def follows_clock(node: Node) -> bool:
    """Returns whether a node's time is that of /clock, a simulation's."""
    return bool(node.get_parameter("use_sim_time").value)


def steady_clock() -> Clock:
    """The clock that is never set, for what must go on whatever /clock does."""
    return Clock(clock_type=ClockType.STEADY_TIME)


def seconds(clock: Clock) -> float:
    """The present time of a clock [s]."""
    return clock.now().nanoseconds * 1e-9


def described_age(age: float) -> str:
    """An age [s] in words, to follow "no pose": "yet" for an infinite one, else "for 1.2 s"."""
    return "yet" if age == float("inf") else f"for {age:.1f} s"
