"""The robot behind a serial line: the line, the driver, the firmware and what that reports."""

from dataclasses import replace
from itertools import count
from operator import methodcaller

from collplan_ros.messages.states import FREE, HELD, STOPPED
from faults.fault import NOTHING, Act, Fault, Measured
from faults.live_graph import LiveGraph, at_full_speed
from faults.stands import WAIT, no_motion_since, wheels_stop, why_followed_again
from faults.streams import why_lost

AGE = 0.25
"""Oldest command that the wheels may follow: limits.command_age, a frame and a step of the firmware [s]."""
FIRMWARE = 0.2
"""Longest time from a button or a motor's fault to zero at the wheels [s]."""
STILL = 1.0
"""Time for which a robot must stand after the fault is over [s]."""
DRIVES = 0.5
"""Time for which it drives on with a low battery [s]."""
EMULATOR = "firmware_emulator"
_restarts = count(1)


def oldest_followed(graph: LiveGraph, begun: float) -> Measured:
    """Age of the command that the wheels followed when they were stopped, by the firmware's clock."""
    streams = graph.streams
    graph.until(lambda: streams.stops and streams.stops[-1].sent > begun, WAIT)
    graph.rest()
    stops = [row for row in streams.stops if row.sent > begun]
    stalled = why_lost(streams.losses, begun, stops[-1].sent) if stops else ""
    age = max((row.age for row in stops), default=None)
    speed, way = streams.motion_at(begun).speed, streams.way_since(begun)
    return Measured(age, "", stalled, streams.why_stood(begun), speed, way)


def then_still(graph: LiveGraph, measured: Measured, state: str = HELD) -> Measured:
    """The same, a miss where the robot moves by itself after the fault is over."""
    begun = graph.now()
    graph.pause(STILL)
    # the state of a node that was started again may reach this process later than its health
    graph.until(lambda: graph.state == state, WAIT)
    wrong = no_motion_since(graph, begun) or ("" if graph.state == state else f"it is {graph.state}, expected {state}")
    return replace(measured, missed=measured.missed or wrong)


def let(**values: object) -> Act:
    """Sets parameters of the emulator; returns when it began to [s, steady clock]."""

    def act(graph: LiveGraph) -> float:
        begun = graph.now()
        graph.let(EMULATOR, **values)
        return begun

    return act


def plugged_in(graph: LiveGraph) -> None:
    graph.let(EMULATOR, emulator__unplugged=False)
    graph.until(lambda: graph.healthy("driver_node"), WAIT)


def link_lost(graph: LiveGraph, begun: float) -> Measured:
    measured = oldest_followed(graph, begun)
    plugged_in(graph)
    return then_still(graph, measured)


def driver_again(graph: LiveGraph, begun: float) -> Measured:
    measured = oldest_followed(graph, begun)
    graph.restart("driver_node")
    return then_still(graph, measured)


def estop_kept(graph: LiveGraph, begun: float) -> Measured:
    graph.rest()
    graph.restart("driver_node")
    graph.until(lambda: graph.state == STOPPED, WAIT)
    return then_still(graph, Measured(), STOPPED)


def stopped_and_driver_killed(graph: LiveGraph) -> float:
    graph.trigger("estop")
    return graph.kill("driver_node")


def freeze_both(graph: LiveGraph) -> float:
    """The driver freezes, and its commander a little later."""
    begun = graph.freeze("driver_node")
    graph.pause(graph.chance.uniform(0.0, 0.2))
    graph.freeze("controller_node")
    return begun


def old_command(graph: LiveGraph, begun: float) -> Measured:
    """Whether the driver, running again, follows what was commanded before: its commander is frozen still."""
    graph.pause(graph.chance.uniform(0.25, 0.8))  # silent for over 1 s it would be held
    again = graph.thaw("driver_node")
    graph.pause(0.5)
    measured = oldest_followed(graph, begun)
    return replace(measured, missed=why_followed_again(graph.streams.stops, graph.streams.truth, again))


def thaw_both(graph: LiveGraph) -> None:
    graph.thaw("driver_node")
    graph.thaw("controller_node")


def firmware_restarts(graph: LiveGraph) -> float:
    return let(emulator__restarts=next(_restarts))(graph)


def stopped_and_firmware_restarts(graph: LiveGraph) -> float:
    graph.trigger("estop")
    graph.rest()
    return firmware_restarts(graph)


def held(graph: LiveGraph, begun: float) -> Measured:
    return then_still(graph, wheels_stop(HELD)(graph, begun))


def kept(graph: LiveGraph, begun: float) -> Measured:
    return then_still(graph, Measured(), STOPPED)


def clear(graph: LiveGraph) -> None:
    graph.until(lambda: graph.trigger("clear_estop"), WAIT)


def released(graph: LiveGraph) -> None:
    graph.let(EMULATOR, emulator__estop_pressed=False)
    clear(graph)


def refused(graph: LiveGraph, begun: float) -> Measured:
    """It stands, and nobody can let it move as long as a motor has failed or is too hot."""
    measured = wheels_stop(HELD)(graph, begun)
    return replace(measured, missed="resume is not refused") if graph.trigger("resume") else measured


def next_refused(graph: LiveGraph, begun: float) -> Measured:
    """It drives on to its goal, and stands at the next one."""
    graph.pause(DRIVES)
    if graph.state != FREE:
        return Measured(missed=f"it is {graph.state} on the way to its goal")
    begun = graph.now()
    graph.give_goal(graph.farther_end())
    return wheels_stop(HELD)(graph, begun)


def well_again(graph: LiveGraph) -> None:
    graph.let(EMULATOR, emulator__motor_fault=False, emulator__too_hot=False, emulator__battery=7.6)
    graph.pause(0.1)


def row(name: str, limit: float | None, act: Act, measure, undo=NOTHING, long: int = 100) -> Fault:
    return Fault(name, "serial", limit, act, measure, undo, long)


AGED = "age of the last command followed"
COMMANDER, DRIVER = "controller_node", "driver_node"
FAULTS = [
    row(
        f"cable pulled and back: {AGED}, then no motion",
        AGE,
        at_full_speed(let(emulator__unplugged=True)),
        link_lost,
        plugged_in,
    ),
    row(f"{COMMANDER} frozen: {AGED}", AGE, methodcaller("freeze", COMMANDER), oldest_followed, thaw_both, 200),
    row(
        f"{COMMANDER} killed: {AGED}",
        AGE,
        methodcaller("kill", COMMANDER),
        oldest_followed,
        methodcaller("restart", COMMANDER),
    ),
    row(f"{DRIVER} and its commander frozen, it runs again: {AGED}", AGE, freeze_both, old_command, thaw_both, 200),
    row(f"{DRIVER} killed and started: {AGED}, then no motion", AGE, methodcaller("kill", DRIVER), driver_again),
    row(f"{DRIVER} killed and started in an emergency stop: kept", None, stopped_and_driver_killed, estop_kept, clear),
    row("firmware restarts, then no motion", FIRMWARE, firmware_restarts, held),
    row("firmware restarts in an emergency stop: kept", None, stopped_and_firmware_restarts, kept, clear),
    row("button on the robot", FIRMWARE, let(emulator__estop_pressed=True), wheels_stop(STOPPED), released),
    row("motor fault", FIRMWARE, let(emulator__motor_fault=True), refused, well_again),
    row("motors too hot", FIRMWARE, let(emulator__too_hot=True), refused, well_again),
    row("battery low: the next goal is refused", 0.5, let(emulator__battery=6.2), next_refused, well_again),
]
