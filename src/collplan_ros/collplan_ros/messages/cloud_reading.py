"""Reads the project's point clouds by their attributes alone: plans, what the planner sees and compares, impacts.

A message decoded from a recording will do as well as one of rclpy's, and no ROS is needed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from collplan_core.impact import SOURCES, Impact
from collplan_core.plan import Contacts, Plan, plan_of_path
from collplan_core.validation import rising
from collplan_ros.messages.reading import MessageError, check_finite, check_frame, seconds_from_stamp

FREE_SPACE, FRONTIERS, PREDICTED, REMEMBERED, INFERRED = LAYERS = (
    "free_space",
    "frontiers",
    "predicted",
    "remembered",
    "inferred",
)
"""Layers of planner/seen, by the number in its field `layer`: a closed polygon, and lines of two points each."""
PLACES = ("x", "y", "vx", "vy", "line")
"""Fields of planner/compared before the cost terms: position, velocity, and which line of points it belongs to."""
TOTAL = "total"
IMPACT = ("x", "y", "normal_x", "normal_y", "before_vx", "before_vy", "after_vx", "after_vy")
"""Fields of impact/contact before `source`: point, unit normal out of the obstacle, velocity before and after."""
SOURCE, WITH_MOVER = "source", "with_mover"
"""Fields of impact/contact: number of its source in SOURCES, and whether the obstacle moves."""
PLAN = ("t", "x", "y", "vx", "vy", "normal_x", "normal_y", "kind")
"""Fields of planner/trajectory: time after the plan's stamp [s], and by `kind` of the point one of the next."""
ON_PATH, AT_CONTACT, HOLDS, DRIVEN = 0, 1, 2, 3
"""The robot's centre and its velocity there; a contact's point, velocity after it and unit normal out of the obstacle;
how long the plan holds, where nothing else counts; and of the drive that it was made with, where that is learnt, the
delay as t, the largest acceleration as x and the lag as y."""
KINDS = {7: "<f4", 8: "<f8", 2: "|u1"}
"""Types of fields that are used, by their numbers in sensor_msgs/PointField: FLOAT32, FLOAT64 and UINT8."""


@dataclass(frozen=True, eq=False)
class Compared:
    """Candidates that a plan was chosen from: single ones, or whole rollouts."""

    rows: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))  # (m, 4) x, y, vx, vy of each [m], [m/s]
    terms: Mapping[str, np.ndarray] = field(default_factory=dict)  # (m,) each cost term by its name, TOTAL among them
    paths: Sequence[np.ndarray] = ()  # (n, 2) of rollouts, n > 1 [m]
    costs: Sequence[float] = ()  # of each rollout


def seen_from_message(message: Any, frame: str) -> dict[str, np.ndarray]:
    """Points (n, 2) [m] of each layer of LAYERS in a message.

    MessageError: another frame, other fields, or fewer bytes than it says.
    """
    table = _table(message, frame)
    _check_fields(table, ("x", "y", "layer"))
    points = _pairs(table, "x", "y").astype(float)
    return {name: points[table["layer"] == number] for number, name in enumerate(LAYERS)}


def compared_from_message(message: Any, frame: str) -> Compared:
    """The candidates compared; MessageError: another frame, other fields, or fewer bytes than it says."""
    table = _table(message, frame)
    _check_fields(table, (*PLACES, TOTAL))
    rows = np.column_stack([table[name] for name in PLACES[:4]]).astype(float)
    starts = np.flatnonzero(np.diff(table["line"], prepend=np.nan) != 0.0)
    lengths = np.diff(starts, append=len(table))
    terms = {name: table[name].astype(float) for name in table.dtype.names or () if name not in PLACES}
    long = lengths > 1
    paths = [rows[start : start + length, :2] for start, length in zip(starts[long], lengths[long], strict=True)]
    single = starts[~long]
    singles = {name: values[single] for name, values in terms.items()}
    return Compared(rows[single], singles, paths, terms[TOTAL][starts[long]].tolist())


def plan_from_message(message: Any, frame: str) -> Plan:
    """The plan in a message of planner/trajectory; how it was chosen is not in it.

    MessageError: another frame, other fields, fewer bytes than it says, fewer than 2 points of the path, not finite, or
    times of the path that do not rise.
    """
    table = _table(message, frame)
    _check_fields(table, PLAN)
    stamp, kinds = seconds_from_stamp(message.header.stamp), table["kind"]
    path, touched, ends, driven = (table[kinds == kind] for kind in (ON_PATH, AT_CONTACT, HOLDS, DRIVEN))
    times = rising("points", stamp + path["t"], MessageError)
    positions, velocities = _pairs(path, "x", "y"), _pairs(path, "vx", "vy")
    points, after, normals = (_pairs(touched, *names) for names in (("x", "y"), ("vx", "vy"), ("normal_x", "normal_y")))
    if not all(np.isfinite(each).all() for each in (positions, touched["t"], points, after, ends["t"])):
        raise MessageError("points: got a position, contact or end that is not finite")
    alone = bool(np.isnan(velocities).all())
    if not (alone or np.isfinite(velocities).all()):
        raise MessageError("points: got a velocity that is not finite, expected all or none of them to be")
    contacts = Contacts(stamp + touched["t"], points, after, normals)
    until = stamp + float(ends["t"][0]) if len(ends) else None
    plan = plan_of_path(stamp, times, positions, None if alone else velocities, until, contacts)
    if not len(driven):
        return plan
    drive = float(driven["x"][0]), float(driven["y"][0]), float(driven["t"][0])
    check_finite("points", *drive)
    return replace(plan, drive=drive)


def _pairs(table: np.ndarray, x: str, y: str) -> np.ndarray:
    return np.column_stack([table[x], table[y]])


def impact_from_cloud(message: Any, frame: str) -> Impact:
    """The impact in a message, in `frame`.

    MessageError: another frame, other fields, other than one point, not finite, or of an unknown source.
    """
    table = _table(message, frame)
    _check_fields(table, (*IMPACT, SOURCE))
    if len(table) != 1:
        raise MessageError(f"width: got {len(table)} points, expected 1")
    values = [float(table[name][0]) for name in IMPACT]
    check_finite("data", *values)
    source = int(table[SOURCE][0])
    if source >= len(SOURCES):
        raise MessageError(f"source: got {source}, expected one of 0 to {len(SOURCES) - 1}")
    point, normal, before, after = np.array(values).reshape(4, 2)
    # recordings of an earlier version do not say it
    moves = WITH_MOVER in (table.dtype.names or ()) and bool(table[WITH_MOVER][0])
    return Impact(seconds_from_stamp(message.header.stamp), point, normal, before, after, SOURCES[source], moves)


def _table(message: Any, frame: str) -> np.ndarray:
    if not hasattr(message, "point_step"):  # as in a recording of an earlier version
        raise MessageError(f"type: got {type(message).__name__}, expected sensor_msgs/PointCloud2")
    check_frame("header.frame_id", message.header.frame_id, frame)
    step, size = int(message.point_step), int(message.width) * int(message.height)
    names, formats, offsets = [], [], []
    for each in message.fields:
        kind = KINDS.get(each.datatype)
        if kind is None or each.count != 1 or each.offset + np.dtype(kind).itemsize > step:
            raise MessageError(f"fields: got {each.name!r} of type {each.datatype}, expected FLOAT32, FLOAT64 or UINT8")
        names.append(str(each.name))
        formats.append(kind)
        offsets.append(int(each.offset))
    if message.is_bigendian or step == 0 or len(message.data) != step * size or len(set(names)) != len(names):
        got = f"{len(message.data)} bytes"
        raise MessageError(f"data: got {got}, expected {size} points of {step} bytes, little endian")
    layout = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": step})
    return np.frombuffer(message.data, layout, count=size) if size else np.zeros(0, layout)


def _check_fields(table: np.ndarray, expected: Sequence[str]) -> None:
    names = table.dtype.names or ()
    if not set(expected) <= set(names):
        raise MessageError(f"fields: got {', '.join(names)}, expected {', '.join(expected)}")
