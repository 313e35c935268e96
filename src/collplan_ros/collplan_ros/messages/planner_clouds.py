"""Point clouds: a plan, what the planner sees and compares, and an impact; markers take as long as a plan.

planner/seen holds lines of several layers; planner/compared the candidates of the choice, with each cost term in a
field of its own, so that a viewer of point clouds can colour by it.
"""

from array import array
from collections.abc import Mapping

import numpy as np
from sensor_msgs.msg import PointCloud2, PointField

from collplan_core.impact import SOURCES, Impact
from collplan_core.local_map import LocalMap
from collplan_core.parameters import Settings
from collplan_core.parameters.groups import RADIUS
from collplan_core.plan import Candidates, Plan
from collplan_core.time_to_goal_planner.boundary_memory.update import INFERRED_DEPTH
from collplan_core.time_to_goal_planner.boundary_memory.working import RememberedBoundaries
from collplan_ros.messages.cloud_reading import (
    AT_CONTACT,
    DRIVEN,
    FREE_SPACE,
    FRONTIERS,
    HOLDS,
    IMPACT,
    INFERRED,
    KINDS,
    LAYERS,
    PLACES,
    PLAN,
    PREDICTED,
    REMEMBERED,
    SOURCE,
    TOTAL,
    WITH_MOVER,
)
from collplan_ros.messages.conversions import header

SEEN = np.dtype({"names": ["x", "y", "layer"], "formats": ["<f4", "<f4", "u1"], "offsets": [0, 4, 8], "itemsize": 12})
ARROW_LENGTH = 0.15
"""Drawn length of a predicted boundary [m]."""
MOST_COMPARED = 500
"""Number of the cheapest candidates that are published and drawn: each takes time."""
_NUMBERS = {kind: number for number, kind in KINDS.items()}


# ---- planner/trajectory

_PLAN = np.dtype([*((name, "<f8") for name in PLAN[:-1]), (PLAN[-1], "u1")])


def plan_to_message(plan: Plan, frame: str) -> PointCloud2:
    """Message of a plan with its contacts; one without an end of validity holds to the end of its path."""
    contacts, n = plan.contacts, len(plan.times)
    k = n + len(contacts.times)
    table = np.zeros(k + 1 + (plan.drive is not None), _PLAN)
    path, touched = table[:n], table[n:k]
    path["t"], path["x"], path["y"] = plan.times - plan.stamp, *plan.positions.T
    path["vx"], path["vy"] = (np.nan, np.nan) if plan.velocities is None else plan.velocities.T
    touched["kind"], touched["t"] = AT_CONTACT, contacts.times - plan.stamp
    touched["x"], touched["y"] = contacts.points.T
    touched["vx"], touched["vy"] = contacts.velocities_after.T
    touched["normal_x"], touched["normal_y"] = contacts.normals.T
    until = plan.times[-1] if plan.valid_until is None else plan.valid_until
    table["kind"][k], table["t"][k] = HOLDS, until - plan.stamp
    if plan.drive is not None:
        table["kind"][-1], (table["x"][-1], table["y"][-1], table["t"][-1]) = DRIVEN, plan.drive
    return _cloud(table, plan.stamp, frame)


# ---- planner/seen


def seen_to_message(layers: Mapping[str, np.ndarray], stamp: float, frame: str) -> PointCloud2:
    """Message of points (n, 2) [m] of each layer in LAYERS, at a stamp [s]."""
    points = [np.asarray(layers.get(name, ())).reshape(-1, 2) for name in LAYERS]
    table = np.zeros(sum(map(len, points)), SEEN)
    table["x"], table["y"] = np.concatenate(points).T
    table["layer"] = np.repeat(np.arange(len(LAYERS)), [len(each) for each in points])
    return _cloud(table, stamp, frame)


def seen_layers(
    local_map: LocalMap, remembered: RememberedBoundaries | None, settings: Settings
) -> dict[str, np.ndarray]:
    """Points (n, 2) [m] of each layer of LAYERS; boundaries that none are remembered of have none."""
    origins, tangents = local_map.predicted[:, :2], local_map.predicted[:, 2:]
    layers = {
        FREE_SPACE: local_map.border_points,
        FRONTIERS: local_map.segments.reshape(-1, 2),
        PREDICTED: np.stack([origins, origins + ARROW_LENGTH * tangents], axis=1).reshape(-1, 2),
    }
    if remembered is None:
        return layers
    return layers | {
        REMEMBERED: remembered.pieces.reshape(-1, 2),
        INFERRED: inferred_lines(remembered, settings),
    }


def inferred_lines(remembered: RememberedBoundaries, settings: Settings) -> np.ndarray:
    """(2n, 2) ends of a line into the inferred solid behind each piece; boundaries are those of the robot's centre."""
    here = remembered.solid_behind & ~remembered.seen_free_behind
    middles = remembered.pieces[here].reshape(-1, 2, 2).mean(axis=1)
    radius = settings.robot.radius
    depth = max(INFERRED_DEPTH * (radius / RADIUS) - 2.0 * radius, 0.0)
    return np.stack([middles, middles - depth * remembered.normals[here]], axis=1).reshape(-1, 2)


# ---- planner/compared


def compared_to_message(candidates: Candidates, stamp: float, frame: str) -> PointCloud2:
    """Message of the rollouts that were compared, or where there are none of the cheapest candidates, at a stamp [s].

    Points of one `line` are one rollout, whose velocities are left at zero; a candidate is a line of one point.
    """
    if candidates.paths:
        return _cloud(_rollout_table(candidates), stamp, frame)
    told = cheapest(candidates)
    terms = {TOTAL: candidates.costs, **candidates.terms}
    table = _empty_table(len(told), tuple(terms))
    table["x"], table["y"] = candidates.positions[told].T
    table["vx"], table["vy"] = candidates.velocities[told].T
    table["line"] = np.arange(len(told))
    for name, values in terms.items():
        table[name] = values[told]
    return _cloud(table, stamp, frame)


def cheapest(candidates: Candidates) -> np.ndarray:
    """Indices of the MOST_COMPARED cheapest candidates, the cheapest first."""
    return np.argsort(candidates.costs, kind="stable")[:MOST_COMPARED]


def _rollout_table(candidates: Candidates) -> np.ndarray:
    known = [(path, cost) for path, cost in zip(candidates.paths, candidates.path_costs, strict=True) if len(path) > 1]
    lengths = [len(path) for path, _ in known]
    table = _empty_table(sum(lengths), (TOTAL,))
    table["x"], table["y"] = np.concatenate([np.zeros((0, 2)), *(path for path, _ in known)]).T
    table["line"] = np.repeat(np.arange(len(lengths)), lengths)
    table[TOTAL] = np.repeat([cost for _, cost in known], lengths)
    return table


def _empty_table(size: int, terms: tuple[str, ...]) -> np.ndarray:
    return np.zeros(size, [(name, "<f4") for name in (*PLACES, *terms)])


# ---- point clouds


def _cloud(table: np.ndarray, stamp: float, frame: str) -> PointCloud2:
    """Message of a structured array, a point a row and a field of the message for each of its own."""
    names, layout = table.dtype.names or (), table.dtype
    fields = [
        PointField(name=name, offset=offset, datatype=_NUMBERS[layout[name].str], count=1)
        for name, offset in zip(names, _offsets(layout), strict=True)
    ]
    return PointCloud2(
        header=header(stamp, frame),
        height=1,
        width=len(table),
        fields=fields,
        is_bigendian=False,
        point_step=table.dtype.itemsize,
        row_step=table.nbytes,
        data=array("B", table.tobytes()),
        is_dense=bool(all(np.isfinite(table[name]).all() for name in names)),
    )


def _offsets(layout: np.dtype) -> list[int]:
    fields = layout.fields
    return [] if fields is None else [fields[name][1] for name in layout.names or ()]


# ---- impact/contact


def impact_to_cloud(impact: Impact, frame: str) -> PointCloud2:
    """Message of an impact in `frame`."""
    values = *impact.point, *impact.normal, *impact.velocity_before, *impact.velocity_after
    layout = [*((name, "<f8") for name in IMPACT), (SOURCE, "|u1"), (WITH_MOVER, "|u1")]
    kinds = SOURCES.index(impact.source), impact.with_mover
    return _cloud(np.array([(*values, *kinds)], layout), impact.time, frame)
