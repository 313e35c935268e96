"""A person's hand on a joystick: it takes the robot over, lets go, dies on the way, and gives the robot back."""

import math
from bisect import bisect_right
from collections.abc import Callable
from itertools import pairwise

from sensor_msgs.msg import Joy

from collplan_core.command import HAND
from collplan_core.control.joystick import RELEASED_FOR
from collplan_core.parameters import Settings
from collplan_ros.messages.qos import NEWEST
from faults.bench import BenchError
from faults.fault import Act, Fault, Measured
from faults.live_graph import ANSWER, TELEOP, LiveGraph
from faults.stands import WAIT, Measure, commanded_to_stand
from faults.stops import COMMANDER, SecondPublisher
from faults.streams import why_stalled

RELEASED = 0.12
"""Longest time from the release of the dead-man button to zero: a control period, and what two messages take [s]."""
TAKEN = 0.2
"""Longest time from the press of the dead-man button to the first command by hand [s]: the very first one of a sender
is left out, and the next comes with the joystick's next message."""
BACK = 0.4
"""Longest time from the resume button to the planner's first command that moves: a service, a message, a period [s]."""
SILENT = 0.32
"""Longest time from the last message of joystick or teleop_node to zero: teleop.joy_age or limits.hand_age, two
periods, and what two messages take [s]."""
PERIOD = 0.05
"""Of the joystick's messages, as joy_node repeats them [s]."""
DRIVES = 0.4, 0.8
"""For so long a hand drives [s]."""
STANDS = 0.6
"""For so long the robot stands between a release and resume [s]."""
SETTINGS = Settings()


Undo = Callable[[LiveGraph], None]


class Joystick:
    """A pad with the buttons as shipped, in the bench's own process."""

    def __init__(self) -> None:
        self._message = Joy()

    def plug_in(self, graph: LiveGraph) -> None:
        """Sends from now on, with nothing pressed, until teleop_node has seen that for long enough.

        Raises:
            BenchError: nobody listens.
        """
        self._publisher = graph.listener.node.create_publisher(Joy, "joy", NEWEST)
        self._message = Joy(axes=[0.0] * 6, buttons=[0] * 11)
        if not graph.until(lambda: self._publisher.get_subscription_count() > 0, ANSWER):
            raise BenchError("teleop_node does not listen to joy")
        graph.repeat(PERIOD, self.send)
        graph.pause(RELEASED_FOR + 4 * PERIOD)

    def send(self) -> None:
        self._publisher.publish(self._message)

    def show(self, graph: LiveGraph, left: float = 0.0, dead_man: bool = False, resume: bool = False) -> float:
        """Moves the stick and presses or releases buttons, and sends that; returns when [s, steady clock]."""
        teleop = SETTINGS.teleop
        self._message.axes[teleop.left_axis] = left
        self._message.buttons[teleop.dead_man_button] = int(dead_man)
        self._message.buttons[teleop.resume_button] = int(resume)
        begun = graph.now()
        self.send()
        return begun

    def unplug(self, graph: LiveGraph) -> None:
        """Sends no more."""
        graph.repeat(PERIOD, None)
        graph.listener.node.destroy_publisher(self._publisher)


joystick = Joystick()


def drive(graph: LiveGraph) -> None:
    """A hand takes the robot over and drives it to the left for a while.

    Raises:
        BenchError: it does not have the robot then.
    """
    joystick.plug_in(graph)
    joystick.show(graph, left=1.0, dead_man=True)
    graph.pause(graph.chance.uniform(*DRIVES))
    if graph.streams.maneuvers[-1].what != HAND:
        raise BenchError(f"a hand does not have the robot: {graph.described()}")


def release(graph: LiveGraph) -> float:
    drive(graph)
    return joystick.show(graph)


def fall_silent(graph: LiveGraph) -> float:
    drive(graph)
    begun = joystick.show(graph, left=1.0, dead_man=True)
    graph.repeat(PERIOD, None)
    return begun


def drive_and(act: str) -> Act:
    def acting(graph: LiveGraph) -> float:
        drive(graph)
        return getattr(graph, act)(TELEOP)

    return acting


def press(graph: LiveGraph) -> float:
    joystick.plug_in(graph)
    graph.pause(graph.chance.uniform(0.0, PERIOD))
    return joystick.show(graph, left=1.0, dead_man=True)


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
    return joystick.show(graph, resume=True)


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


def unplug_and(act: str) -> Undo:
    def undo(graph: LiveGraph) -> None:
        joystick.unplug(graph)
        getattr(graph, act)(TELEOP)

    return undo


def hand(name: str, limit: float, act: Act, measure: Measure, undo: Undo = joystick.unplug) -> Fault:
    return Fault(name, "simulator", limit, act, measure, undo, long=200)


stands = commanded_to_stand(0.6)
second = SecondPublisher("hand/cmd_vel")
FAULTS = [
    hand("dead-man button released", RELEASED, release, stands),
    hand("joystick silent while a hand drives", SILENT, fall_silent, stands),
    hand("teleop_node frozen while a hand drives", SILENT, drive_and("freeze"), stands, unplug_and("thaw")),
    hand("teleop_node killed while a hand drives", SILENT, drive_and("kill"), stands, unplug_and("restart")),
    Fault("second publisher on hand/cmd_vel", "simulator", COMMANDER, second.begin, stands, second.end, long=50),
    hand("a hand takes over: time until its first command, without a jump", TAKEN, press, has_taken_over),
    hand("a hand gives back: time from resume until the planner drives", BACK, give_back, has_been_given_back),
]
