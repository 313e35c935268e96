"""From one scan and the pose it was taken at to the local map: the stages in order."""

import math
from typing import Any

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import free_space, step_out
from collplan_core.local_map.frontiers import find_frontiers, find_jumps
from collplan_core.local_map.predicted import find_predicted
from collplan_core.local_map.record import LocalMap
from collplan_core.local_map.surfaces import HIT, beam_kinds, find_surfaces, fit_pieces
from collplan_core.parameters import LocalMapping, Robot
from collplan_core.scan import Scan
from collplan_core.state import State


@njit
def _build(ranges: np.ndarray, angle_min: float, step: float, closed: bool, range_min: float, radius: float,
           half_side: float, n_rays: int, tolerance: float, grazing: float) -> tuple[Any, ...]:  # fmt: skip
    kind, distance = beam_kinds(ranges, range_min)
    hits = np.zeros((len(ranges), 2))
    for i in range(len(ranges)):
        if kind[i] == HIT:
            hits[i, 0] = distance[i] * math.cos(angle_min + i * step)
            hits[i, 1] = distance[i] * math.sin(angle_min + i * step)
    joined = find_surfaces(kind, distance, hits, step, closed, grazing, tolerance)
    pieces, owner, surface_of = fit_pieces(kind, hits, joined, tolerance)
    sx, sy = step_out(pieces, radius)
    box = np.array([-half_side - sx, -half_side - sy, half_side - sx, half_side - sy])
    for k in range(len(pieces)):
        pieces[k, 0] -= sx
        pieces[k, 1] -= sy
        pieces[k, 2] -= sx
        pieces[k, 3] -= sy
    reach, ends, surface, normals, straight = free_space(
        pieces, owner, radius, box, n_rays, kind, distance, joined, surface_of, angle_min, step, closed
    )
    jumps = find_jumps(reach, ends, surface, normals, straight, grazing)
    segments, frontier_kind, number, lit = find_frontiers(reach, ends, surface, jumps, box)
    predicted = find_predicted(reach, ends, surface, normals, jumps)
    return (
        sx,
        sy,
        reach,
        ends,
        surface,
        normals,
        jumps,
        segments,
        frontier_kind,
        number,
        lit,
        predicted,
        pieces,
        owner,
        distance,
    )


def build_local_map(scan: Scan, state: State, robot: Robot, mapping: LocalMapping) -> LocalMap:
    """The local map from a scan and the pose at its stamp, never from the world. Paper: II-A.

    Obstacles are grown by the robot's radius and `clearance`; the planner then moves a point.
    """
    ranges, angle_min, step = scan.ranges, scan.angle_min + state.yaw, scan.angle_increment
    if step < 0.0:
        ranges, angle_min, step = ranges[::-1], angle_min + step * (len(ranges) - 1), -step
    if step * (len(ranges) - 1) > 2 * math.pi - 0.5 * step:  # the last beam repeats the first
        ranges = ranges[:-1]
    closed = abs(step * len(ranges) - 2 * math.pi) < 0.5 * step
    radius = robot.radius + mapping.clearance
    sx, sy, reach, ends, surface, normals, jumps, segments, kind, number, lit, predicted, pieces, owner, view = _build(
        np.ascontiguousarray(ranges), angle_min, step, closed, scan.range_min, radius, mapping.half_side,
        mapping.n_rays, mapping.surface_tolerance, mapping.grazing_angle,
    )  # fmt: skip
    center = state.position + np.array([sx, sy])
    predicted[:, :2] += center
    return LocalMap(
        stamp=scan.stamp, position=center, radius=radius, half_side=mapping.half_side, reach=reach,
        points=ends + center, surface=surface, normals=normals, shadow=jumps,
        segments=segments + np.concatenate([center, center]), frontier_kind=kind, frontier_number=number,
        lit=lit >= 0, predicted=predicted, walls=pieces + np.concatenate([center, center]), wall_surface=owner,
        view=view, view_from=np.array([*state.position, angle_min, step]),
    )  # fmt: skip
