"""How long until the robot is commanded to stand, or stands by itself, and that it goes on standing."""

from collections.abc import Callable

from collplan_ros.messages.states import HELD
from faults.live_graph import WAIT, LiveGraph, at_full_speed
from faults.runner import Fault, Measure, Measured
from faults.streams import why_stalled

CALL = 0.2
"""Longest time from the call of estop to zero at the robot [s]."""
NO_MOTION, OCCLUSION = 2.0, 0.4
"""Time watched after clear_estop, in which poses are lost: the controller's zeros must not let it move [s]."""


def commanded_to_stand(hold: float, since: Callable[[LiveGraph, float], float] | None = None) -> Measure:
    """Measures the time from a fault to the zero command that only zeros follow, for `hold` [s] after the fault.

    The time of the zero is that at which the controller sent it. `since` is when mocap_node sent what the controller
    acts on; the time is counted from then on, and both nodes must run. A node that stalls between stamping and sending
    has not told the controller anything yet.
    """

    def measure(graph: LiveGraph, begun: float) -> Measured:
        streams = graph.streams
        came = graph.until(lambda: streams.commands[-1].sent > begun + hold, hold + WAIT)
        first = since(graph, begun) if since else begun
        stands = streams.stands_from(first)
        graph.rest()
        way = streams.speed_and_way(begun)
        if stands is None:
            return Measured(None, "" if came else "no commands", **way)
        stalled = why_stalled("controller_node", streams.commands, begun, stands)
        if since:
            stalled = stalled or streams.why_mocap_stalled(first, stands)
        return Measured(stands - first, "", stalled, streams.why_stood(begun), **way)

    return measure


def robot_stops(state: str) -> Measure:
    """Measures the time until the robot's node says that it is in `state`, which it does once it has commanded zero."""
    return _stops(lambda streams: [row for row in streams.states if row.what == state])


def wheels_stop(state: str) -> Measure:
    """Measures the time until the firmware has set the wheels to zero; then the driver says that it is in `state`."""
    measure = _stops(lambda streams: streams.stops)
    return lambda graph, begun: measure(graph, begun).then(graph.why_not(state))


def _stops(rows: Callable) -> Measure:
    """Measures the time until the first of some rows of the robot's own side."""

    def measure(graph: LiveGraph, begun: float) -> Measured:
        streams = graph.streams

        def first() -> float | None:
            return next((row.sent for row in rows(streams) if row.sent > begun), None)

        graph.until(first, WAIT)
        at = first()
        graph.rest()
        stalled = "" if at is None else why_stalled("the robot's node", streams.truth, begun, at)
        seconds = None if at is None else at - begun
        return Measured(seconds, "", stalled, streams.why_stood(begun), **streams.speed_and_way(begun))

    return measure


def estop_fault(robot: str, stops: Measure) -> Fault:
    """Nothing moves for NO_MOTION after clear_estop, though the controller loses its poses for a moment."""

    def act(graph: LiveGraph) -> float:
        begun = graph.now()
        graph.trigger("estop")
        return begun

    def measure(graph: LiveGraph, begun: float) -> Measured:
        measured = stops(graph, begun)
        graph.trigger("clear_estop")
        cleared = graph.now()
        graph.pause(0.5)
        graph.freeze("mocap_node")
        graph.pause(OCCLUSION)
        graph.thaw("mocap_node")
        graph.pause(cleared + NO_MOTION - graph.now())
        return measured.then(graph.streams.why_moved(cleared), graph.why_not(HELD))

    name = f"estop; then clear_estop, {NO_MOTION:g} s and poses lost for a moment: no motion"
    return Fault(name, robot, CALL, at_full_speed(act), measure, lambda graph: graph.trigger("clear_estop"), long=500)
