"""What run.mcap tells of a run beyond record.jsonl, as parts of frames: what was thought, and what nodes said."""

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from collplan_ros.node_kit.node_names import is_in
from collplan_ros.recording.description import RUN
from collplan_ros.recording.reading import description, messages
from collplan_ros.runs.send_times import ArrivalTimes
from collplan_ros.view import scene
from collplan_ros.view.message_parts import (
    Parts,
    compared_parts,
    costs_parts,
    doing_parts,
    hold_parts,
    report_of,
    seen_parts,
)
from collplan_ros.view.player.played_run import PlayedRun
from collplan_ros.view.player.run_frames import Event

CLOUDS = ("planner/seen", "planner/compared")
"""Topics of which not every message of a long run is shown."""
NODES_PERIOD = 0.5
"""Shortest time between two states of all nodes [s]."""


def mcap_events(run: PlayedRun, path: Path) -> Iterator[Event]:
    """What a recording holds of the time of the run; of a long one not all that was seen and compared.

    Raises:
        RunError: the recording cannot be read.
        MessageError: a message in it is not as planner_node publishes it.
    """
    log, arrivals = run.record.log, ArrivalTimes(run.record.wall_clock)
    clouds: Counter[str] = Counter()
    takers = _takers(run, description(path, RUN).get("namespace", "/"))
    for topic, came, message in messages(path, list(takers)):
        at = log.stamp_at(arrivals.steady(1e-9 * came))
        if topic in CLOUDS:
            clouds[topic] += 1
            if (clouds[topic] - 1) % run.one_in:
                continue
        for part, value in takers[topic](message, at):
            yield Event(at, part, value)


Taker = Callable[[Any, float], Parts]
"""Takes a message and when it came [s, poses' clock]; gives the parts that it makes new."""


def _takers(run: PlayedRun, namespace: str) -> dict[str, Taker]:
    frame = run.settings.frames.map
    return {
        "planner/seen": lambda message, _: seen_parts(message, frame),
        "planner/compared": lambda message, _: compared_parts(message, frame),
        "planner/costs": lambda message, _: costs_parts(message),
        "controller/state": lambda message, _: doing_parts(message),
        "robot/state": lambda message, _: hold_parts(message),
        "/diagnostics": _Nodes(namespace).take,
    }


class _Nodes:
    """What the nodes of the run's namespace say of themselves, all of them together."""

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
