"""The two clocks of a node: a local one for ages and timers, and the poses' clock, which stamps are read on."""

from rclpy.clock import Clock, ClockType
from rclpy.node import Node


def local_clock(node: Node) -> Clock:
    """The clock for a node's timers and ages: the steady clock, or the node's own where it follows /clock.

    System time is unsuitable: it steps when it is synchronised, and timers on it then stall.
    """
    if node.get_parameter("use_sim_time").value:
        return node.get_clock()
    return Clock(clock_type=ClockType.STEADY_TIME)


def seconds(clock: Clock) -> float:
    """The present time of a clock [s]."""
    return clock.now().nanoseconds * 1e-9


class PosesClock:
    """Estimate of the time on the poses' clock: stamp of the newest pose + local time since it was received.

    The clock of a motion-capture computer may be seconds off; it is never compared with the local one.
    """

    def __init__(self) -> None:
        self._stamp: float | None = None
        self._local = 0.0

    def received(self, stamp: float, local: float) -> None:
        """Registers a pose with this stamp [s, poses' clock], received at `local` [s, local clock]."""
        self._stamp, self._local = stamp, local

    def now(self, local: float) -> float | None:
        """The time on the poses' clock [s]; None before the first pose."""
        return None if self._stamp is None else self._stamp + (local - self._local)

    def age(self, local: float) -> float:
        """Local time since the newest pose was received [s]; infinite before the first."""
        return float("inf") if self._stamp is None else local - self._local


def described_age(age: float) -> str:
    """An age [s] in words, to follow "no pose": "yet" for an infinite one, else "for 1.2 s"."""
    return "yet" if age == float("inf") else f"for {age:.1f} s"
