"""The local clock of a node, for ages, and timers for what it does each period."""

from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.timer import Timer

IN_STEP = 4_000_000
"""Calls are in step that lie so near to where they belong [ns]: messages come sooner or later."""


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


def call_each_period(node: Node, period: float, act: Callable[[], None], clock: Clock) -> Timer:
    """A timer of `node` that calls `act` each `period` [s] of `clock`, and never twice for one period.

    EventsExecutor (rclpy 7.1.6) calls a timer twice where /clock comes again before it was called, and then not in the
    next period. The next call stays where it was due: a simulation may wait for what is done in it.
    """

    def tick() -> None:
        early = timer.time_until_next_call() - timer.timer_period_ns
        if early > 0:
            call_in(timer, early)
        else:
            act()

    timer = node.create_timer(period, tick, clock=clock)
    return timer


def call_in(timer: Timer, left: int) -> None:
    """Has a timer called in `left` [ns], and from then on in its own period."""
    period = timer.timer_period_ns
    timer.timer_period_ns = left
    timer.reset()
    timer.timer_period_ns = period


def keep_step(timer: Timer, period: float, lead: float) -> None:
    """Moves a timer's calls to `lead` [s] before those of a caller that calls each `period` [s] and has just called.

    Does nothing where the timer's own period is not a multiple of the other one.
    """
    other, own = round(1e9 * period), timer.timer_period_ns
    if own % other:
        return
    left = timer.time_until_next_call()
    late = (left + round(1e9 * lead) + other // 2) % other - other // 2
    if abs(late) > IN_STEP:
        call_in(timer, left - late if left > late else left - late + other)
