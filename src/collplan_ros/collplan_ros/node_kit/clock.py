"""The local clock of a node, for ages and timers."""

from collections.abc import Callable
from typing import Protocol

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


class Times(Protocol):
    """The time by which the ages of messages are measured."""

    def now(self) -> float:
        """The present time [s]."""

    def sent(self, wall: float) -> float:
        """The time of a message that was sent at `wall` [s, system's clock of its sender], up to a constant [s]."""


class SimulatedTimes:
    """Simulated time, which stands still while a message is on its way."""

    def __init__(self, now: Callable[[], float]) -> None:
        """`now` gives the present time [s]."""
        self.now = now

    def sent(self, wall: float) -> float:
        """Returns the present time [s]: it was sent in the moment in which it came."""
        return self.now()


class SteadyTimes:
    """Real time, by the steady clock of this machine."""

    def __init__(self) -> None:
        self._clock = steady_clock()

    def now(self) -> float:
        """The present time of the steady clock [s]."""
        return seconds(self._clock)

    def sent(self, wall: float) -> float:
        """Returns it unchanged: the two clocks differ by a constant, until one of them is set."""
        return wall
