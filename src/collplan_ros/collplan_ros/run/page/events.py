"""Events of a run, as parts of frames: from its log, and from messages of its nodes."""

import math
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import pairwise
from typing import Any

import numpy as np

from collplan_core.evaluation.impact_matching import KINDS
from collplan_core.goal import ACTIVE, NO_GOAL
from collplan_core.scan import ScanError
from collplan_core.sensing.lidar_mount import placed_among
from collplan_core.sensing.pose_history import state_at
from collplan_ros.node_kit.node_names import is_in
from collplan_ros.run.page.played_run import PlayedRun
from collplan_ros.run.page.run_frames import Event, Frame
from collplan_ros.run.reader import raw_messages
from collplan_ros.run.recorded_run import NANO
from collplan_ros.run.run_log import RunLog, SentGoal, SentStatus, states_around
from collplan_ros.view import scene
from collplan_ros.view.impacts import MOST
from collplan_ros.view.message_parts import (
    Parts,
    compared_parts,
    costs_parts,
    doing_parts,
    hold_parts,
    parts_without_goal,
    report_of,
    seen_parts,
)

CLOUDS = ("planner/seen", "planner/compared")
"""Topics of which not every message of a long run is shown."""
NODES_PERIOD = 0.5
"""Shortest time between two states of all nodes [s]."""


def beginning(played: PlayedRun) -> Frame:
    """Parts that hold from the first frame on."""
    run = played.run
    robot, planner = run.settings.robot, run.settings.planner
    return {
        "about": {
            "robot": scene.SIMULATED if run.log.simulated else scene.REAL,
            "namespace": "/",
            "world": run.world.name,
            "radius": scene.milli([robot.radius])[0],
            "max_speed": scene.milli([robot.max_speed])[0],
            "tolerance": scene.milli([planner.goal_tolerance])[0],
            "spacing": scene.milli([run.settings.remembered.spacing])[0],
        },
        "world": scene.world(run.world),
        "machine": played.machine,
        "goal": _goal(run.log.goal, NO_GOAL),
        "impacts": [],
    }


def log_events(played: PlayedRun) -> Iterator[Event]:
    """Yields measurements, plans, commands and the status of goals."""
    yield from _scans(played)
    yield from _plans(played)
    yield from _impacts(played)
    yield from _periods(played.run.log)
    yield from _goals(played.run.log)


def message_events(played: PlayedRun) -> Iterator[Event]:
    """Yields the planner's clouds and the nodes' messages; of a long run not all clouds (see `decimation`).

    Raises:
        RunError: the recording cannot be read.
        MessageError: a message in it is not as planner_node publishes it.
    """
    run, takers, clouds = played.run, _takers(played), Counter[str]()
    for each in raw_messages(run.recording, list(takers)):
        at = run.log.stamp_at((each.came - run.clock_ahead) / NANO)
        if each.topic in CLOUDS:
            clouds[each.topic] += 1
            if (clouds[each.topic] - 1) % played.decimation:
                continue
        for part, value in takers[each.topic](each.decoded, at):
            yield Event(at, part, value)


def _scans(played: PlayedRun) -> Iterator[Event]:
    log = played.run.log
    for scan in log.scans[:: played.decimation]:
        states = states_around(log.poses, scan)
        state = state_at(states, scan.stamp)
        with suppress(ScanError):  # nothing of it is used
            placed = placed_among(scan, state, states, played.run.settings.scan)
            yield Event(scan.stamp, "scan", scene.scan(placed, state))


def _plans(played: PlayedRun) -> Iterator[Event]:
    log = played.run.log
    for plan in log.plans.values():
        # a plan made by hand has no more than its start
        came = log.stamp_at(plan.sent) if math.isfinite(plan.sent) else plan.stamp
        part = scene.plan(plan.stamp, plan.times, plan.positions, plan.contacts)
        yield Event(came, "plan", part | {"stamp": scene.time_of(plan.stamp - played.zero)})


def _impacts(played: PlayedRun) -> Iterator[Event]:
    found: list[scene.Part] = []
    counts = dict.fromkeys(KINDS, 0)
    for k, time in enumerate(played.impacts.times.tolist()):
        impact = _impact(played, k)
        found = [*found, impact][-MOST:]
        counts = {**counts, impact["kind"]: counts[impact["kind"]] + 1}
        yield Event(time, "impacts", found)
        yield Event(time, "counts", counts)


def _impact(played: PlayedRun, k: int) -> scene.Part:
    impacts, time = played.impacts, float(played.impacts.times[k])
    place, normal, speed = impacts.points[k], impacts.normals[k], float(impacts.speeds[k])
    known = bool(np.isfinite([*place, *normal, speed]).all())
    # in a world without surfaces only the robot's own place is known
    return {
        "t": scene.time_of(time - played.zero),
        "at": scene.milli(place if known else state_at([pose.state for pose in played.run.log.poses], time).position),
        "normal": scene.milli(normal) if known else [0, 0],
        "kind": impacts.verdicts.kind(k),
        "speed": scene.milli([speed])[0] if known else None,
    }


def _periods(log: RunLog) -> Iterator[Event]:
    """The time from each command to the next."""
    for before, after in pairwise(log.sent_commands):
        yield Event(log.stamp_at(after.sent), "periods", [round(1e3 * (after.sent - before.sent), 2)])


def _goals(log: RunLog) -> Iterator[Event]:
    """Yields goals, and the planner's reports on them."""
    target, status = log.goal, NO_GOAL
    rows: list[SentGoal | SentStatus] = [*log.goals, *log.statuses]
    for row in sorted(rows, key=lambda row: row.sent):
        at = log.stamp_at(row.sent)
        if isinstance(row, SentGoal):
            target = np.array(row[1:])
        else:
            status = row.status
        yield Event(at, "goal", _goal(target, status))
        if not isinstance(row, SentGoal) and status not in ACTIVE:
            yield from (Event(at, *part) for part in parts_without_goal())


def _goal(target: np.ndarray, status: str) -> scene.Part:
    return scene.goal(target if np.isfinite(target).all() else None, status)


Taker = Callable[[Any, float], Parts]
"""Takes a message and when it came [s, poses' clock]; gives the parts that it makes new."""


def _takers(played: PlayedRun) -> dict[str, Taker]:
    frame = played.run.settings.frames.map
    return {
        "planner/seen": lambda message, _: seen_parts(message, frame),
        "planner/compared": lambda message, _: compared_parts(message, frame),
        "planner/costs": lambda message, _: costs_parts(message),
        "controller/state": lambda message, _: doing_parts(message),
        "robot/state": lambda message, _: hold_parts(message),
        "/diagnostics": _Nodes(played.run.namespace).take,
    }


class _Nodes:
    """Reports of the nodes in the run's namespace, all of them together."""

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self._reports: dict[str, scene.NodeReport] = {}
        self._due = float("-inf")

    def take(self, message: Any, now: float) -> Parts:
        """Takes a message of /diagnostics that came `now` [s]."""
        for status in message.status:
            report = report_of(status, now)
            if is_in(self._namespace, report.name):
                self._reports[report.name] = report
        if now >= self._due:
            self._due = now + NODES_PERIOD
            yield "nodes", scene.nodes(self._reports.values(), now)
