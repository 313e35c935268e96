"""Faults of a base without our firmware, behind base_node."""

import math
import signal
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import accumulate, pairwise

import foreign_robot
from collplan_core.control.runaway import LAGS
from collplan_core.parameters import Settings
from collplan_ros.bringup.options import COMMANDER
from collplan_ros.messages.states import HELD
from collplan_ros.nodes.localisation import LONGEST_SILENCE
from faults.base_graph import ROBOT, BaseGraph
from faults.fault import Act, Fault, Measured
from faults.nodes import LOST, SILENCE, WATCHED
from faults.stands import CREEP, WAIT, commanded_to_stand, no_motion_since
from faults.streams import AT_REST, STALL, Motion, why_stalled

BRAKING = ROBOT["max_speed"] / ROBOT["max_acceleration"] + LAGS * ROBOT["velocity_lag"]
"""Time to brake from full speed, and until the rest that its lag leaves has gone [s]."""
MESSAGES = 0.15
"""Time that a few messages take, and the periods of a pose and of the controller [s]."""
SHOWN, SHOWN_DRIVING = 0.3, 1.4
"""Longest time from the first late motion to zero, of a robot that starts and of one that drove in time before [s]."""
TURNED = 0.3
"""Longest way of a robot that moves against its commands [m]."""
CHANGED = 0.1
"""Change of the commanded velocity that a delay of the motion shows by [m/s]."""


def telling(fault: str) -> Act:
    return lambda graph: graph.tell_base(fault)


def well(graph: BaseGraph) -> None:
    """Takes away whatever was done to the base."""
    graph.signal_base(signal.SIGCONT)
    graph.start_base()
    graph.tell_base("")
    graph.rest()


def frozen(graph: BaseGraph, begun: float) -> Measured:
    """Zero is sent, and once it runs again it takes that: its wheels went on meanwhile, until its watchdog."""
    measured = commanded_to_stand(0.6)(graph, begun)
    again = graph.signal_base(signal.SIGCONT)
    measured = then_stands(graph, again, measured)
    return replace(measured, distance=graph.streams.way_since(begun))


def killed(graph: BaseGraph, begun: float) -> Measured:
    measured = commanded_to_stand(0.6)(graph, begun)
    graph.end_base()
    graph.start_base()
    return then_stands(graph, graph.now(), replace(measured, distance=None))


def then_stands(graph: BaseGraph, again: float, measured: Measured) -> Measured:
    """Adds that a base which runs again comes to rest, is held, and does not move."""
    came = graph.until(lambda: graph.streams.truth[-1].sent > again, 10.0)
    graph.rest()
    rested = graph.now()
    graph.pause(WATCHED)
    wrong = ("" if came else "it is not back") or no_motion_since(graph, rested)
    return replace(measured, missed=measured.missed or wrong or why_not_held(graph))


def why_not_held(graph: BaseGraph, words: str = "") -> str:
    """Says that neither robot nor controller is held, or for another reason than these words; empty where one is."""

    def reasons() -> list[str]:
        robot = graph.streams.states[-1].why if graph.state == HELD else ""
        return [why for why in (robot, graph.value(COMMANDER, "held")) if why]

    return "" if graph.until(lambda: any(words in why for why in reasons()), WAIT) else f"it is not held: {reasons()}"


def held_for(words: str, hold: float) -> Callable[[BaseGraph, float], Measured]:
    """Measures the time until zero is sent, and whether it is held after LOST for a reason with these words."""

    def measure(graph: BaseGraph, begun: float) -> Measured:
        measured = commanded_to_stand(hold + LOST)(graph, begun)
        return replace(measured, missed=measured.missed or why_not_held(graph, words))

    return measure


def why_stalled_since(graph: BaseGraph, begun: float) -> str:
    """Whether base_node, mocap_node or the base itself stalled, in words: its wheels turn in real time."""
    streams, now = graph.streams, graph.now()
    lived = [row.sent for row in streams.truth if row.sent > begun]
    lost = now - begun - foreign_robot.PERIOD * len(lived)
    base = f"the base did not run for {lost:.2f} s" if lost > STALL else ""
    sent = why_stalled("base_node", (row.sent for row in streams.commands), begun, now)
    return base or sent or streams.why_mocap_stalled(begun, now)


def deaf(graph: BaseGraph) -> float:
    graph.tell_base("deaf")
    graph.pause(graph.chance.uniform(0.1, 0.4))
    begun = graph.now()
    graph.trigger("cancel")
    return begun


def told_of(graph: BaseGraph, begun: float) -> Measured:
    """The time from the first zero sent to the robot's word that its base drives on."""
    streams = graph.streams

    def said() -> float | None:
        return next((row.sent for row in streams.states if row.sent > begun and "drives on" in row.why), None)

    graph.until(said, BRAKING + WAIT)
    zero, told = streams.stands_from(begun), said()
    speed = streams.motion_at(begun).speed
    if zero is None or told is None:
        return Measured(None, unbegun=streams.why_stood(begun), speed=speed)
    return Measured(told - zero, "", why_stalled_since(graph, begun), streams.why_stood(begun), speed)


def late_from_rest(graph: BaseGraph) -> float:
    graph.trigger("cancel")
    graph.rest()
    graph.tell_base("late")
    graph.pause(0.2)
    begun = graph.now()
    graph.give_goal(graph.farther_end())
    return begun


def late_while_it_drives(graph: BaseGraph) -> float:
    """Goals before and behind it in turn, so that the commands change, until it is held."""
    behind, ahead = graph.ends if graph.streams.commands[-1].x > 0.0 else graph.ends[::-1]
    graph.until(lambda: graph.room(behind) > 4.0, 6.0)
    begun = graph.tell_base("late")
    for k in range(6):
        graph.give_goal((behind, ahead)[k % 2])
        if graph.until(lambda: "held" in graph.recorder.standing, 1.0):
            break
    return begun


def late_stands(graph: BaseGraph, begun: float) -> Measured:
    """The time from when the motion begins that the first change of the commands should have begun LATE before."""
    streams = graph.streams
    held = why_not_held(graph)
    graph.rest()
    rows = [row for row in streams.commands if row.sent > begun]
    changed = (row.sent for row in rows if math.hypot(row.x - rows[0].x, row.y - rows[0].y) > CHANGED)
    first = next(changed, begun) + foreign_robot.LATE
    zero = streams.stands_from(first)
    stalled = why_stalled_since(graph, begun)
    moved = [row for row in streams.truth if row.sent > first]
    fastest = max(row.speed for row in moved)
    return Measured(None if zero is None else zero - first, held, stalled, "", fastest, length(moved))


def length(rows: Sequence[Motion]) -> float:
    """Length of a way [m]."""
    return sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(rows))


def reversed_way(graph: BaseGraph, begun: float) -> Measured:
    """How far it drives the other way, and how fast."""
    measured = commanded_to_stand(2.0)(graph, begun)
    rows = [row for row in graph.streams.truth if row.sent > begun]
    ahead = math.copysign(1.0, rows[min(5, len(rows) - 1)].x - rows[0].x)
    turn = max(range(len(rows)), key=lambda k: ahead * rows[k].x)
    back = rows[turn:]
    way, speed = length(back), max(row.speed for row in back)
    wrong = f"{way:.2f} m, limit {TURNED:g} m" if way > TURNED else ""
    wrong = wrong or ("it drives on" if rows[-1].speed > AT_REST else "") or why_not_held(graph)
    stalled = why_stalled_since(graph, begun)
    return replace(measured, seconds=None, missed=measured.missed or wrong, stalled=stalled, speed=speed, distance=way)


def watchdog(graph: BaseGraph, begun: float) -> Measured:
    """The time from the last velocity sent until the base slows by its own watchdog, and that it is held later."""
    graph.pause(foreign_robot.WATCHDOG + MESSAGES)
    graph.rest()
    last = graph.streams.commands[-1].sent
    rows = [row for row in graph.streams.truth if row.sent > begun]
    fastest = accumulate((row.speed for row in rows), max)
    slows = next((row.sent for row, top in zip(rows, fastest, strict=True) if row.speed < top - CREEP), None)
    speed, way = graph.streams.motion_at(begun).speed, graph.streams.way_since(begun)
    stood = graph.streams.why_stood(begun)
    again = graph.restart("base_node")
    measured = Measured(None if slows is None else slows - last, "", "", stood, speed, way)
    return then_stands(graph, again, measured)


BASE = "base"
FAULTS = [
    Fault(
        "base's process frozen, it runs again: held",
        BASE,
        SILENCE,
        lambda g: g.signal_base(signal.SIGSTOP),
        frozen,
        well,
    ),
    Fault(
        "base's process killed and started: held", BASE, SILENCE, lambda g: g.signal_base(signal.SIGKILL), killed, well
    ),
    Fault("base sends nothing any more, but obeys: held", BASE, SILENCE, telling("silent"), held_for("", 0.0), well),
    Fault(
        "localisation silent: held, by its name",
        BASE,
        LONGEST_SILENCE + SILENCE,
        telling("unlocalised"),
        held_for("no transform from map to odom", LONGEST_SILENCE),
        well,
    ),
    Fault("base 0.3 s late from rest on: from its first motion", BASE, SHOWN, late_from_rest, late_stands, well),
    Fault(
        "base 0.3 s late while it drives to and fro: from its first late motion",
        BASE,
        SHOWN_DRIVING,
        late_while_it_drives,
        late_stands,
        well,
    ),
    Fault(
        "base reversed while it drives: 0.3 m the other way at most",
        BASE,
        None,
        telling("reversed"),
        reversed_way,
        well,
    ),
    Fault(
        "base deaf: from zero until it is held and told; nothing stops it",
        BASE,
        BRAKING + Settings().base.runaway_time + MESSAGES,
        deaf,
        told_of,
        well,
    ),
    Fault(
        "base_node killed: until the base's own watchdog of 0.5 s slows it",
        BASE,
        foreign_robot.WATCHDOG + MESSAGES,
        lambda g: g.kill("base_node"),
        watchdog,
        well,
    ),
]
