"""The robot behind a serial line: the line, its commander, the driver, the firmware and what that reports."""

from itertools import count
from operator import methodcaller

from collplan_ros.bringup.options import COMMANDER
from collplan_ros.messages.states import HELD, STOPPED
from faults.live_graph import WAIT, LiveGraph, at_full_speed
from faults.runner import Act, Fault, Measure, Measured
from faults.stands import estop_fault, wheels_stop
from faults.streams import why_lost

AGE, FIRMWARE = 0.25, 0.2
"""Oldest command that the wheels may follow, and longest time from a button or a motor's fault to their zero [s]."""
STILL = 1.0
"""Time for which a robot must stand after the fault is over [s]."""
EMULATOR, DRIVER = "firmware_emulator", "driver_node"
_restarts = count(1)


def oldest_followed(graph: LiveGraph, begun: float) -> Measured:
    """Age of the command that the wheels followed when they were stopped, by the firmware's clock."""
    streams = graph.streams
    graph.until(lambda: streams.stops and streams.stops[-1].sent > begun, WAIT)
    graph.rest()
    stops = [row for row in streams.stops if row.sent > begun]
    stalled = why_lost(streams.losses, begun, stops[-1].sent) if stops else ""
    age = max((row.age for row in stops), default=None)
    return Measured(age, "", stalled, streams.why_stood(begun), **streams.speed_and_way(begun))


def still_after(measure: Measure, mend: Act = lambda graph: None) -> Measure:
    """The same, a miss where the robot moves by itself once the fault is mended, or is not held."""
    return lambda graph, begun: measure(graph, begun).then(_why_not_still(graph, mend))


def _why_not_still(graph: LiveGraph, mend: Act) -> str:
    mend(graph)
    begun = graph.now()
    graph.pause(STILL)
    # the state of a node that was started again may reach this process later than its health
    wrong = graph.why_not(HELD)
    return graph.streams.why_moved(begun) or wrong


def let(faults: str) -> Act:
    return lambda graph: graph.let(EMULATOR, emulator__faults=faults)


def plugged_in(graph: LiveGraph) -> None:
    let("")(graph)
    graph.until(lambda: graph.healthy(DRIVER), WAIT)


def released(graph: LiveGraph) -> None:
    let("")(graph)
    graph.until(lambda: graph.trigger("clear_estop"), WAIT)


def refused(graph: LiveGraph, begun: float) -> Measured:
    """It stands, and nobody can let it move as long as a motor has failed or is too hot."""
    measured = wheels_stop(HELD)(graph, begun)
    return measured.then("resume is not refused" if graph.trigger("resume") else "")


def row(name: str, limit: float, act: Act, measure: Measure, undo: Act = lambda graph: None, long: int = 100) -> Fault:
    return Fault(name, "serial", limit, act, measure, undo, long)


AGED = "age of the last command followed"
unplug, restarts = let("unplugged"), lambda graph: let(f"restarts={next(_restarts)}")(graph)
freeze, thaw = methodcaller("freeze", COMMANDER), methodcaller("thaw", COMMANDER)
kill, restart = methodcaller("kill", COMMANDER), methodcaller("restart", COMMANDER)
FAULTS = [
    estop_fault("serial", wheels_stop(STOPPED)),
    row(
        f"cable pulled and back: {AGED}, then no motion",
        AGE,
        at_full_speed(unplug),
        still_after(oldest_followed, plugged_in),
        plugged_in,
    ),
    row(f"{COMMANDER} frozen: {AGED}", AGE, freeze, oldest_followed, thaw, 200),
    row(f"{COMMANDER} killed: {AGED}", AGE, kill, oldest_followed, restart),
    row(
        f"{DRIVER} killed and started: {AGED}, then no motion",
        AGE,
        methodcaller("kill", DRIVER),
        still_after(oldest_followed, methodcaller("restart", DRIVER)),
    ),
    row("firmware restarts, then no motion", FIRMWARE, restarts, still_after(wheels_stop(HELD))),
    row("button on the robot", FIRMWARE, let("estop_pressed"), wheels_stop(STOPPED), released),
    row("motor fault", FIRMWARE, let("motor_fault"), refused, let("")),
    row("motors too hot", FIRMWARE, let("too_hot"), refused, let("")),
]
