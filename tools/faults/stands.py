"""How long until the robot is commanded to stand, or stands by itself, and whether it goes on standing."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import accumulate

from faults.fault import Measured
from faults.live_graph import LiveGraph
from faults.streams import Motion, WheelStop, why_stalled

Measure = Callable[[LiveGraph, float], Measured]
WAIT = 2.0
"""Longest wait for what should be there at once [s]."""
CREEP = 0.06
"""A robot that was at rest has moved where it is faster [m/s]."""


def commanded_to_stand(hold: float, since: Callable[[LiveGraph, float], float] | None = None) -> Measure:
    """Measures the time from a fault to the zero command that only zeros follow, for `hold` [s] after the fault.

    The time of the zero is that at which the controller sent it.

    Args:
        since: when mocap_node sent what the controller acts on; the time is counted from then on, and both nodes must
            run. A node that stalls between stamping and sending has not told the controller anything yet.
    """

    def measure(graph: LiveGraph, begun: float) -> Measured:
        streams = graph.streams
        came = graph.until(lambda: streams.commands[-1].sent > begun + hold, hold + WAIT)
        first = since(graph, begun) if since else begun
        stands = streams.stands_from(first)
        graph.rest()
        speed, way = streams.motion_at(begun).speed, streams.way_since(begun)
        if stands is None:
            return Measured(None, "" if came else "no commands", speed=speed, distance=way)
        stalled = why_stalled("controller_node", (row.sent for row in streams.commands), begun, stands)
        if since:
            stalled = stalled or streams.why_mocap_stalled(first, stands)
        return Measured(stands - first, "", stalled, streams.why_stood(begun), speed, way)

    return measure


def robot_stops(state: str) -> Measure:
    """Measures the time until the robot's node says that it is in `state`, which it does once it has commanded zero."""

    def measure(graph: LiveGraph, begun: float) -> Measured:
        streams = graph.streams
        graph.until(lambda: streams.states[-1].what == state and streams.states[-1].sent > begun, WAIT)
        said = next((row for row in streams.states if row.what == state and row.sent > begun), None)
        return stopped(graph, begun, None if said is None else said.sent)

    return measure


def wheels_stop(state: str) -> Measure:
    """Measures the time until the firmware has set the wheels to zero; then the driver says that it is in `state`."""

    def measure(graph: LiveGraph, begun: float) -> Measured:
        streams = graph.streams
        graph.until(lambda: streams.stops and streams.stops[-1].sent > begun, WAIT)
        stop = next((row for row in streams.stops if row.sent > begun), None)
        measured = stopped(graph, begun, None if stop is None else stop.sent)
        if not state or graph.until(lambda: graph.state == state, WAIT):
            return measured
        return replace(measured, missed=f"the robot is {graph.state}, expected {state}")

    return measure


def stopped(graph: LiveGraph, begun: float, at: float | None) -> Measured:
    """What came of a stop that the robot's own side did at `at` [s, steady clock]; None where it did not."""
    streams = graph.streams
    graph.rest()
    speed, way = streams.motion_at(begun).speed, streams.way_since(begun)
    stood = streams.why_stood(begun)
    if at is None:
        return Measured(None, unbegun=stood, speed=speed, distance=way)
    stalled = why_stalled("the robot's node", (row.sent for row in streams.truth), begun, at)
    return Measured(at - begun, "", stalled, stood, speed, way)


def why_followed_again(stops: Iterable[WheelStop], truth: Iterable[Motion], since: float) -> str:
    """What shows that a robot whose wheels were stopped has followed a command since [s], in words; else empty."""
    if any(stop.sent > since for stop in stops):
        return "the wheels have turned again"
    speeds = [row.speed for row in truth if row.sent > since]
    gained = max((speed - slowest for speed, slowest in zip(speeds, accumulate(speeds, min), strict=True)), default=0.0)
    return f"it has gained {gained:.2f} m/s" if gained > CREEP else ""


def no_motion_since(graph: LiveGraph, begun: float) -> str:
    """Whether a robot that was at rest has moved since then, in words; empty where it has not."""
    fastest = max((row.speed for row in graph.streams.truth if row.sent > begun), default=0.0)
    return f"it moved, at {fastest:.2f} m/s" if fastest > CREEP else ""
