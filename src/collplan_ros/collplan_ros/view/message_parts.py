"""Parts of frames from messages, by attributes alone: of a live graph, and of a recording read without ROS."""

from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from collplan_ros.messages.cloud_reading import (
    FREE_SPACE,
    FRONTIERS,
    INFERRED,
    LAYERS,
    PREDICTED,
    REMEMBERED,
    compared_from_message,
    seen_from_message,
)
from collplan_ros.messages.status_values import values_of
from collplan_ros.view import scene

Parts = Iterator[tuple[str, scene.Part]]
"""Name and value of each part that a message makes new."""
NAMES = {
    FREE_SPACE: "free",
    FRONTIERS: "frontiers",
    PREDICTED: "predicted",
    REMEMBERED: "remembered",
    INFERRED: "inferred",
}
"""Parts by layer of planner/seen."""
WARN = 1
"""DiagnosticStatus.WARN: level at which the controller reports that the robot stands though a goal is active."""


def seen_parts(message: Any, frame: str, shown: Collection[str] = LAYERS) -> Parts:
    """The layers `shown` of planner/seen."""
    for layer, points in seen_from_message(message, frame).items():
        if layer in shown:
            yield NAMES[layer], scene.milli(points)


def compared_parts(message: Any, frame: str) -> Parts:
    """Yields the parts of a frame made from planner/compared."""
    found = compared_from_message(message, frame)
    yield "candidates", scene.candidates(found.rows, found.terms)
    yield "rollouts", scene.rollouts(found.paths, found.costs)


def parts_without_goal() -> Parts:
    """Yields empty parts of the plan, for when no goal is active."""
    yield "plan", None
    for name in ("free", "frontiers", "predicted", "rollouts"):
        yield name, []
    yield "candidates", scene.candidates(np.zeros((0, 4)), {})


def costs_parts(message: Any) -> Parts:
    """Yields the parts of a frame made from planner/costs."""
    for status in message.status:
        yield "costs", scene.costs(values_of(status))


def doing_parts(message: Any) -> Parts:
    """Yields the parts of a frame made from controller/state."""
    values = values_of(message)
    told = {name: values.get(name, "") for name in ("maneuver", "reason")}
    yield "doing", told | {"warn": _level(message) >= WARN}


def drive_parts(message: Any) -> Parts:
    """Yields the parts of a frame made from controller/drive."""
    yield "drive", {"message": str(message.message), "warn": _level(message) >= WARN}


def hold_parts(message: Any) -> Parts:
    """Yields the parts of a frame made from robot/state."""
    yield "hold", {"state": values_of(message).get("state", ""), "message": str(message.message)}


def report_of(status: Any, now: float) -> scene.NodeReport:
    """Returns a node's report on /diagnostics, received at `now` [s]."""
    return scene.NodeReport(str(status.name), _level(status), str(status.message), values_of(status), now)


def _level(status: Any) -> int:
    """Returns the level of a status: a `byte` is bytes in rclpy, and a number in other readers."""
    level = status.level
    return level[0] if isinstance(level, bytes) else int(level)
