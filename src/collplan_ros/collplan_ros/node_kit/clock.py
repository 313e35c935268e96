"""Two times: the node's local one, which ages are measured in, and the poses' one, which stamps are written in."""

from rclpy.clock import Clock, ClockType
from rclpy.node import Node


def local_clock(node: Node) -> Clock:
    """The clock for a node's timers and ages: steady, or the node's own where it follows /clock.

    System time steps when it is synchronised, and timers on it then stall.
    """
    if node.get_parameter("use_sim_time").value:
        return node.get_clock()
    return Clock(clock_type=ClockType.STEADY_TIME)


def seconds(clock: Clock) -> float:
    """What a clock shows [s]."""
    return clock.now().nanoseconds * 1e-9


class PosesClock:
    """The poses' clock between two poses: stamp of the newest pose + local time since it was received.

    A motion-capture computer's clock may be seconds off; nothing here compares it with the local one.
    """

    def __init__(self) -> None:
        self._stamp: float | None = None
        self._local = 0.0

    def received(self, stamp: float, local: float) -> None:
        """A pose with this stamp [s, poses' clock] has just come in at `local` [s, local clock]."""
        self._stamp, self._local = stamp, local

    def now(self, local: float) -> float | None:
        """The time on the poses' clock [s]; None before the first pose."""
        return None if self._stamp is None else self._stamp + (local - self._local)

    def age(self, local: float) -> float:
        """Local time since the newest pose came in [s]; infinite before the first."""
        return float("inf") if self._stamp is None else local - self._local


def described_age(age: float) -> str:
    """An age [s] in words, after "no pose"."""
    return "yet" if age == float("inf") else f"for {age:.1f} s"
