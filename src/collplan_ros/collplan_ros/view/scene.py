"""Frames sent to the page; each part of them is made here from the project's records.

A frame is one JSON object. `t` is always there; every other key is a *part*, there only where it has changed, and then
whole: it replaces the part of the same name. The page shows the newest of each part up to a time.

Lengths are in mm, speeds in mm/s, angles in mrad, durations in ms, all whole numbers in the world frame; times are in s
on the poses' clock. Points are one flat list x0, y0, x1, y1, ...

    t           time of the frame [s], in ms: that of the newest pose, and on from it where no more come; one that is
                earlier by over 0.5 s begins another way and other plots, as after a restart of the robot
    about       {"robot": "simulated" | "emulated" | "real" | "unknown", "namespace", "world": its name,
                "radius", "max_speed", "tolerance": of the goal, "spacing": width of an inferred strip}
    world       {"bounds": [x0, y0, x1, y1], "walled", "polygons": [[points], ...], "circles": [[x, y, radius], ...]},
                null where it is not known
    robot       [x, y, yaw, vx, vy] at t; with each new pose, also where the robot rests
    trail       [ms before t, x, y, ...]: poses between those of the frame before and of this one
    scan        points that beams of the newest scan ended at
    refused     [[x, y, 1 of a scan or 0 of a pose], ...]: where such were refused since the frame before
    refuses     whether the scan is one that was refused
    free        corners of F, the free space of the disc's centre
    frontiers   two ends of each frontier segment
    predicted   origin and tip of each predicted boundary
    remembered  two ends of each remembered piece of a boundary
    inferred    two ends of each strip of inferred solid, about.spacing wide
    candidates  {"at": [x, y, vx, vy, ...], "terms": {name: [a number for each, ...]}}, "total" among the names
    rollouts    [{"cost": number, "path": points}, ...], the cheapest first
    plan        {"stamp" [s], "times": [ms after the stamp, ...], "path": points,
                "contacts": [x, y, vx, vy, ms after the stamp, ...]}: points touched and velocities after; null: no plan
    goal        {"at": [x, y] or null, "status": none, accepted, executing, succeeded, canceled or aborted}
    doing       {"maneuver", "reason", "warn": whether it stands though a goal is active}
    drive       {"message": the drive that was learnt, in words; "warn": whether it is not what is set}
    hold        {"state": free, held or stopped, "" where no robot was heard; "message"}
    movers      {"stamp" [s], "at": [x, y, vx, vy, radius, ...]}: what moves in a simulated world, the truth
    found       the same of what the planner has found to move
    impacts     the newest 200: {"t", "at": [x, y], "normal": [1000 nx, 1000 ny],
                "kind": "deliberate" | "foreseen" | "other", "speed": into the wall}
    counts      {"deliberate", "foreseen", "other"}: how many impacts there were
    costs       {"planning_time" [ms], "strategy", "hardest": fastest contact foreseen, "terms": {name: number}}
    periods     [ms, ...]: times between two commands since the frame before
    machine     {"pace": "0.85x real time", empty where simulated time runs as it should or the robot is not simulated;
                "verdict": that this machine is too slow for a real robot, and why; empty where it is not}
    nodes       [{"name", "level": 0 to 3, "message", "age" [s], "silent", "values": {name: text}}, ...]
    strategy    {"value": the planner's strategy, "choices": [name, ...]}; null: no planner that has one was heard
    history     earlier frames that hold t, robot, trail, costs and periods alone: first for a page that comes late

`trail`, `refused`, `periods` and plots of `costs` lose what a page that was too slow has skipped; nothing else does.
"""

import math
from collections import deque
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from collplan_core.evaluation.impact_matching import KEPT, KINDS, Prediction, judge_impacts
from collplan_core.impact import Impact
from collplan_core.parameters import Settings
from collplan_core.parameters.file import NODES
from collplan_core.plan import Contacts, Plan
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import World

Part = Any
"""A part of a frame, ready for JSON."""
Values = Mapping[str, object]
"""Parameters of a node by name."""

SIMULATED, EMULATED, REAL, UNKNOWN = "simulated", "emulated", "real", "unknown"
"""Which robot it is: without hardware; without hardware, over a serial line; of hardware; not known."""
TELL = {*NODES} - {"view_node"}
"""Names of the nodes that tell their parameters."""
SILENT_AFTER = 2.5
"""Time without diagnostics after which a node counts as silent [s]: each sends them once a second."""
LARGEST = 1e6
"""Farthest coordinate and fastest speed that is drawn [m], [m/s]."""
NO_TERMS = ("planning_time_ms", "candidates", "foreseen_contacts", "hardest_contact")
OLD_FIGURES = ("rebound_stamp", "rebound_foreseen", "rebound_measured", "rebound_direction")
"""Beginnings of names on planner/costs that are no cost terms; the second ones are of recordings of version 1.0.0."""

MOST = 200
"""Impacts that are shown."""


class SceneError(ValueError):
    """Error of a value that cannot be drawn: not finite, or larger than LARGEST."""


def milli(values: np.ndarray | Sequence[float]) -> list[int]:
    """Numbers of any shape as one list of whole thousandths; SceneError: one is not finite or beyond LARGEST."""
    numbers = np.asarray(values, dtype=float).reshape(-1)
    if not (np.abs(numbers) <= LARGEST).all():
        raise SceneError(f"got {numbers[~(np.abs(numbers) <= LARGEST)][0]}, expected at most {LARGEST:g} in size")
    return np.rint(1e3 * numbers).astype(np.int64).tolist()


def significant(values: np.ndarray | Sequence[float]) -> list[float]:
    """Numbers (n,) to four significant digits; one that is not finite becomes 0, as a term that was not computed."""
    return [float(f"{value:.4g}") if math.isfinite(value) else 0.0 for value in np.asarray(values, dtype=float)]


def robot(state: State) -> Part:
    """The part `robot`."""
    return milli([*state.position, math.remainder(state.yaw, 2 * math.pi), *state.velocity])


def trail(states: Iterable[State], end: float) -> Part:
    """The part `trail` of the states before the time `end` [s]."""
    return milli([value for state in states for value in (end - state.stamp, *state.position)])


def scan(seen: Scan, at: State) -> Part:
    """The part `scan`: where the beams of a scan end that was taken at a state; those that hit nothing are left out."""
    return milli(seen.points(at, np.isfinite(seen.ranges)))


def which_robot(source: str, known: Mapping[str, Values], nodes: Collection[str]) -> str:
    """Returns the kind of the reporting robot, by the parameters of its node; UNKNOWN as long as there is doubt.

    `source` is that node, `known` the parameters that nodes have told, `nodes` all that report, by full names.
    """
    own = known.get(source)
    there = [known[name] for name in {*nodes, source} if name in known]
    firmware = [values["emulator.link"] for values in there if "emulator.link" in values]
    if own is None or sum(map(_is_robot, there)) != 1 or not _is_robot(own):
        return UNKNOWN
    if _is_simulator(own):
        return SIMULATED
    port = own["driver.port"]
    if port in firmware:
        return EMULATED
    # one that has not told its own may be the emulated firmware, and one there is may be at the port by another name
    in_doubt = bool(firmware) or any(name.rpartition("/")[2] in TELL and name not in known for name in nodes)
    leads_to_hardware = isinstance(port, str) and port.startswith("/dev/") and not port.startswith("/dev/pts/")
    return REAL if leads_to_hardware and not in_doubt else UNKNOWN


def _is_robot(values: Values) -> bool:
    """Returns whether a node takes commands; the emulated firmware does not, the driver in front of it does."""
    return "emulator.link" not in values and ("driver.port" in values or _is_simulator(values))


def _is_simulator(values: Values) -> bool:
    return any(name.startswith("simulator.") for name in values)


def about(kind: str, namespace: str, place: str, settings: Settings) -> dict[str, Part]:
    """The part `about` of a robot of this kind with these parameters, in the world of this name."""
    radius, max_speed = milli([settings.robot.radius, settings.robot.max_speed])
    tolerance, spacing = milli([settings.planner.goal_tolerance, settings.remembered.spacing])
    scales = {"radius": radius, "max_speed": max_speed, "tolerance": tolerance, "spacing": spacing}
    return {"robot": kind, "namespace": namespace, "world": place, **scales}


def world(place: World) -> Part:
    """The part `world`."""
    polygons, circles = ([milli(each) for each in shapes] for shapes in (place.polygons, place.circles))
    return {"bounds": milli(place.bounds), "walled": bool(place.walled), "polygons": polygons, "circles": circles}


def candidates(rows: np.ndarray, terms: Mapping[str, np.ndarray]) -> Part:
    """The part `candidates` of rows (m, 4) x, y, vx, vy [m], [m/s] and their cost terms, each (m,)."""
    return {"at": milli(rows), "terms": {name: significant(values) for name, values in terms.items()}}


def rollouts(paths: Sequence[np.ndarray], costs: Sequence[float]) -> Part:
    """The part `rollouts` of paths (n, 2) [m], each with its cost."""
    order = np.argsort(np.asarray(costs, dtype=float), kind="stable").tolist()
    priced = significant(costs)
    return [{"cost": priced[k], "path": milli(paths[k])} for k in order]


def plan(stamp: float, times: np.ndarray, positions: np.ndarray, contacts: Contacts) -> Part:
    """The part `plan` of times (n,) [s], positions (n, 2) [m] and contacts foreseen; it begins at `stamp` [s]."""
    rows = np.column_stack([contacts.points, contacts.velocities_after, contacts.times - stamp])
    return {"stamp": time_of(stamp), "times": milli(times - stamp), "path": milli(positions), "contacts": milli(rows)}


def costs(values: Mapping[str, str]) -> Part:
    """The part `costs` of the figures on planner/costs."""
    numbers = {name: number for name, text in values.items() if (number := _number(text)) is not None}
    terms = {name: number for name, number in numbers.items() if not name.startswith((*NO_TERMS, *OLD_FIGURES))}
    return {
        "planning_time": round(numbers.get("planning_time_ms", 0.0), 2),
        "strategy": values.get("strategy", ""),
        "hardest": milli([numbers.get("hardest_contact", 0.0)])[0],
        "terms": dict(zip(terms, significant(list(terms.values())), strict=True)),
    }


def movers(stamp: float, rows: np.ndarray) -> Part:
    """The part `movers` or `found` of rows (k, 5) x, y [m], vx, vy [m/s], radius [m] at a stamp [s]."""
    return {"stamp": time_of(stamp), "at": milli(rows)}


def impact(happened: Impact, kind: str) -> Part:
    """One entry of the part `impacts`, with its kind."""
    place = {"t": time_of(happened.time), "at": milli(happened.point), "normal": milli(happened.normal)}
    return place | {"kind": kind, "speed": milli([max(0.0, happened.speed_into)])[0]}


class ShownImpacts:
    """The impacts so far, as sent to the page."""

    def __init__(self) -> None:
        self.part: list[Part] = []  # the part `impacts` of a frame, the newest MOST of them
        self.counts = dict.fromkeys(KINDS, 0)  # the part `counts`, of all of them
        self._predictions: deque[Prediction] = deque()

    def planned(self, plan: Plan) -> None:
        """Takes a plan."""
        self._predictions.append(Prediction(plan.stamp, plan.contacts))
        while self._predictions[0].made < plan.stamp - KEPT:
            self._predictions.popleft()

    def happened(self, newest: Impact) -> None:
        """Takes an impact."""
        self.add(impact(newest, judge_impacts([newest], self._predictions).kind(0)))

    def add(self, shown: Part) -> None:
        """Takes an impact as the page shows it."""
        # made anew: what was sent before stays as it was
        self.counts = {**self.counts, shown["kind"]: self.counts[shown["kind"]] + 1}
        self.part = [*self.part, shown][-MOST:]


class NodeReport(NamedTuple):
    """The newest health report of a node: full name, level, message, figures by name, and time of receipt [s]."""

    name: str
    level: int
    message: str
    values: Mapping[str, str]
    came: float


def nodes(reports: Iterable[NodeReport], now: float) -> Part:
    """The part `nodes` at a time on the clock of the reports [s]."""
    rows = []
    for name, level, message, values, came in sorted(reports, key=lambda each: each.name):
        told, age = {"name": name, "level": level, "message": message}, max(0.0, now - came)
        rows.append(told | {"age": round(age), "silent": age > SILENT_AFTER, "values": dict(values)})
    return rows


def time_of(seconds: float) -> float:
    """A time [s] as sent to the page, to the ms; SceneError: it is not finite."""
    if not math.isfinite(seconds):
        raise SceneError(f"got time {seconds}, expected a finite one")
    return round(seconds, 3)


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
