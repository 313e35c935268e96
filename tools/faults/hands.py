"""A person's hand: it takes the robot over, lets go, falls silent, and gives the robot back."""

import math
from bisect import bisect_right
from itertools import pairwise

from geometry_msgs.msg import Twist

from collplan_core.command import HAND
from collplan_core.parameters import Settings
from collplan_ros.messages.qos import NEWEST
from faults.bench import BenchError
from faults.fault import Act, Fault, Measured
from faults.live_graph import ANSWER, LiveGraph
from faults.stands import WAIT, Measure, commanded_to_stand
from faults.stops import COMMANDER, SecondPublisher
from faults.streams import why_stalled

RELEASED = 0.12
"""Longest time from a hand's zero to the controller's: a control period, and what two messages take [s]."""
TAKEN = 0.2
"""Longest time from a hand's first message, which is left out, to the first command by hand [s]."""
BACK = 0.4
"""Longest time from the call of resume to the planner's first command that moves: a message, a period [s]."""
SILENT = 0.32
"""Longest time from a hand's last message to zero: limits.hand_age, two periods, and what two messages take [s]."""
PERIOD = 0.05
"""Time between two messages of a hand, as joy_node repeats those of a joystick [s]."""
SPEED = 0.3
"""Speed of the robot by hand [m/s]."""
TOPIC = "hand/cmd_vel"
DRIVES = 0.4, 0.8
"""For so long a hand drives [s]."""
STANDS = 0.6
"""For so long the robot stands between a release and resume [s]."""
SETTINGS = Settings()


class Hand:
    """Commands by hand, from the bench's own process."""

    def __init__(self) -> None:
        self._message = Twist()

    def come(self, graph: LiveGraph) -> None:
        """Is there from now on, without a command.

        Raises:
            BenchError: nobody listens.
        """
        self._publisher = graph.listener.node.create_publisher(Twist, TOPIC, NEWEST)
        if not graph.until(lambda: self._publisher.get_subscription_count() > 0, ANSWER):
            raise BenchError(f"controller_node does not listen to {TOPIC}")

    def send(self) -> None:
        self._publisher.publish(self._message)

    def push(self, graph: LiveGraph) -> float:
        """Commands the robot to the left from now on; returns since when [s, steady clock]."""
        self._message.linear.y = SPEED
        begun = graph.now()
        graph.repeat(PERIOD, self.send)
        self.send()
        return begun

    def let_go(self, graph: LiveGraph) -> float:
        """Sends a zero, and then nothing; returns when [s, steady clock]."""
        graph.repeat(PERIOD, None)
        self._message.linear.y = 0.0
        begun = graph.now()
        self.send()
        return begun

    def go(self, graph: LiveGraph) -> None:
        """Sends no more."""
        graph.repeat(PERIOD, None)
        graph.listener.node.destroy_publisher(self._publisher)


hand = Hand()


def drive(graph: LiveGraph) -> None:
    """A hand takes the robot over and drives it to the left for a while.

    Raises:
        BenchError: it does not have the robot then.
    """
    hand.come(graph)
    hand.push(graph)
    graph.pause(graph.chance.uniform(*DRIVES))
    if graph.streams.maneuvers[-1].what != HAND:
        raise BenchError(f"a hand does not have the robot: {graph.described()}")


def release(graph: LiveGraph) -> float:
    drive(graph)
    return hand.let_go(graph)


def fall_silent(graph: LiveGraph) -> float:
    drive(graph)
    begun = hand.push(graph)
    graph.repeat(PERIOD, None)
    return begun


def take_over(graph: LiveGraph) -> float:
    hand.come(graph)
    graph.pause(graph.chance.uniform(0.0, PERIOD))
    return hand.push(graph)


def has_taken_over(graph: LiveGraph, begun: float) -> Measured:
    """The time until the first command by hand; from the one before it on there must be no jump but to rest."""
    streams = graph.streams
    graph.until(lambda: streams.maneuvers[-1].what == HAND and streams.maneuvers[-1].sent > begun, WAIT)
    first = next((row.sent for row in streams.maneuvers if row.what == HAND and row.sent > begun), None)
    graph.pause(DRIVES[0])
    rows = list(streams.commands)
    stalled = why_stalled("controller_node", (row.sent for row in rows), begun, graph.now())
    if first is None:
        return Measured(None, "", stalled)
    # a command goes out just before the word of it
    number = bisect_right(rows, first, key=lambda row: row.sent) - 1
    pairs = pairwise(rows[max(number - 1, 0) :])
    jump = max(math.hypot(after.x - row.x, after.y - row.y) for row, after in pairs if after.moves)
    # the drive used may have been learnt, and is another one than is set
    step = streams.largest_acceleration(begun) / SETTINGS.controller.rate + 1e-6
    return Measured(first - begun, f"a jump of {jump:.3f} m/s" if jump > step else "", stalled)


def give_back(graph: LiveGraph) -> float:
    release(graph)
    graph.rest()
    graph.pause(STANDS)
    begun = graph.now()
    if not graph.trigger("resume"):
        raise BenchError(f"resume is refused: {graph.described()}")
    return begun


def has_been_given_back(graph: LiveGraph, begun: float) -> Measured:
    """The time until the planner's first command that moves, with the goal as before."""
    streams = graph.streams

    def first() -> float | None:
        return next((row.sent for row in streams.commands if row.moves and row.sent > begun), None)

    graph.until(first, WAIT)
    moves = first()
    end = graph.now() if moves is None else moves
    stalled = why_stalled("controller_node", (row.sent for row in streams.commands), begun, end)
    missed = "" if graph.goal_goes_on else f"the goal is {streams.goals[-1].what}"
    if any(row.moves for row in streams.commands if begun - STANDS < row.sent < begun):
        missed = "it was commanded to move before"
    return Measured(None if moves is None else moves - begun, missed, stalled)


def second_comes(graph: LiveGraph) -> float:
    hand.come(graph)
    return second.begin(graph)


def both_go(graph: LiveGraph) -> None:
    second.end(graph)
    hand.go(graph)


def by_hand(name: str, limit: float, act: Act, measure: Measure) -> Fault:
    return Fault(name, "simulator", limit, act, measure, hand.go, long=200)


stands = commanded_to_stand(0.6)
second = SecondPublisher(TOPIC)
FAULTS = [
    by_hand("a hand lets go", RELEASED, release, stands),
    by_hand("a hand falls silent while it drives", SILENT, fall_silent, stands),
    Fault("second publisher on hand/cmd_vel", "simulator", COMMANDER, second_comes, stands, both_go, long=50),
    by_hand("a hand takes over: time until its first command, without a jump", TAKEN, take_over, has_taken_over),
    by_hand("a hand gives back: time from resume until the planner drives", BACK, give_back, has_been_given_back),
]
