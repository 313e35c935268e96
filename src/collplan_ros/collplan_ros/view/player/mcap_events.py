"""What run.mcap tells of a run beyond record.jsonl, as parts of frames: what was thought, and what nodes said."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from collplan_ros.messages.cloud_reading import compared_from_message, seen_from_message
from collplan_ros.node_kit.node_names import is_in
from collplan_ros.recording.description import RUN
from collplan_ros.recording.reading import description, messages
from collplan_ros.view import scene
from collplan_ros.view.player.played_run import PlayedRun
from collplan_ros.view.player.run_frames import Event

NODES_PERIOD = 0.5
"""Shortest time between two states of all nodes [s]."""
LAYERS = {
    "free_space": "free",
    "frontiers": "frontiers",
    "predicted": "predicted",
    "remembered": "remembered",
    "inferred": "inferred",
}
"""Parts of frames by layer of planner/seen."""
WARN = 1
"""DiagnosticStatus.WARN: with this the controller says that the robot stands though a goal is active."""


def mcap_events(run: PlayedRun, path: Path) -> Iterator[Event]:
    """What a recording holds of the time of the run.

    Raises:
        RunError: the recording cannot be read.
        MessageError: a message in it is not as planner_node publishes it.
    """
    log, ahead = run.record.log, run.record.wall_clock_ahead
    takers = _takers(run, description(path, RUN).get("namespace", "/"))
    for topic, came, message in messages(path, list(takers)):
        at = log.stamp_at(1e-9 * came - ahead)
        for part, value in takers[topic](message, at):
            yield Event(at, part, value)


Taker = Callable[[Any, float], Iterator[tuple[str, scene.Part]]]
"""Takes a message and when it came [s, poses' clock]; gives the parts that it makes new."""


def _takers(run: PlayedRun, namespace: str) -> dict[str, Taker]:
    frame = run.settings.frames.map
    return {
        "planner/seen": lambda message, _: _seen(message, frame),
        "planner/compared": lambda message, _: _compared(message, frame),
        "planner/costs": lambda message, _: _costs(message),
        "controller/state": lambda message, _: _doing(message),
        "robot/state": lambda message, _: _hold(message),
        "/diagnostics": _Nodes(namespace).take,
    }


def _seen(message: Any, frame: str) -> Iterator[tuple[str, scene.Part]]:
    for layer, points in seen_from_message(message, frame).items():
        yield LAYERS[layer], scene.milli(points)


def _compared(message: Any, frame: str) -> Iterator[tuple[str, scene.Part]]:
    found = compared_from_message(message, frame)
    yield "candidates", scene.candidates(found.rows, found.terms)
    yield "rollouts", scene.rollouts(found.paths, found.costs)


def _costs(message: Any) -> Iterator[tuple[str, scene.Part]]:
    for status in message.status:
        yield "costs", scene.costs(_values(status))


def _doing(message: Any) -> Iterator[tuple[str, scene.Part]]:
    values = _values(message)
    told = {name: values.get(name, "") for name in ("maneuver", "activity", "reason")}
    yield "doing", told | {"warn": _level(message) >= WARN}


def _hold(message: Any) -> Iterator[tuple[str, scene.Part]]:
    yield "hold", {"state": _values(message).get("state", ""), "message": str(message.message)}


class _Nodes:
    """What the nodes of the run's namespace say of themselves, all of them together."""

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self._reports: dict[str, scene.NodeReport] = {}
        self._due = float("-inf")

    def take(self, message: Any, now: float) -> Iterator[tuple[str, scene.Part]]:
        """Takes a message of /diagnostics that came `now` [s]."""
        for status in message.status:
            name = str(status.name)
            if not is_in(self._namespace, name):
                continue
            self._reports[name] = scene.NodeReport(name, _level(status), str(status.message), _values(status), now)
        if now >= self._due:
            self._due = now + NODES_PERIOD
            yield "nodes", scene.nodes(self._reports.values(), now)


def _values(status: Any) -> dict[str, str]:
    return {str(item.key): str(item.value) for item in status.values}


def _level(status: Any) -> int:
    """A `byte` is bytes in rclpy, and a number in other readers."""
    level = status.level
    return level[0] if isinstance(level, bytes) else int(level)
