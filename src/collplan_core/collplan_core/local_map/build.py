"""From one scan and the pose it was taken at to the local map: the stages in order. Paper: II-A."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import FreeSpace, free_space, nearest_free_offset
from collplan_core.local_map.frontiers import Frontiers, find_frontiers, find_shadow_edges
from collplan_core.local_map.predicted import PREDICTED
from collplan_core.local_map.record import LocalMap
from collplan_core.local_map.surfaces import HIT, Beams, Sweep, beam_kinds, find_surfaces, fit_pieces
from collplan_core.parameters import LocalMapping, Robot
from collplan_core.scan import Scan
from collplan_core.state import State


class _Stages(NamedTuple):
    """What the stages leave, relative to the centre of F, which lies at `offset` (2,) from the robot [m]."""

    offset: np.ndarray
    free: FreeSpace
    shadow: np.ndarray
    frontiers: Frontiers
    pieces: np.ndarray
    owner: np.ndarray
    distance: np.ndarray


@njit
def _build(ranges: np.ndarray, sweep: Sweep, radius: float, half_side: float, n_rays: int) -> _Stages:
    """All stages from the ranges of a sweep (b,) [m] to boundaries, free space and frontiers, in order."""
    kind, distance = beam_kinds(ranges, sweep.range_min)
    hits = np.zeros((len(ranges), 2))
    for i in range(len(ranges)):
        if kind[i] == HIT:
            hits[i, 0] = distance[i] * math.cos(sweep.first + i * sweep.step)
            hits[i, 1] = distance[i] * math.sin(sweep.first + i * sweep.step)
    joined = find_surfaces(kind, distance, hits, sweep)
    pieces, owner, surface_of = fit_pieces(kind, hits, joined, sweep.tolerance)
    x, y = nearest_free_offset(pieces, radius)
    box = np.array([-half_side - x, -half_side - y, half_side - x, half_side - y])
    for k in range(len(pieces)):
        pieces[k, 0] -= x
        pieces[k, 1] -= y
        pieces[k, 2] -= x
        pieces[k, 3] -= y
    free = free_space(pieces, owner, Beams(kind, distance, joined, surface_of), sweep, radius, box, n_rays)
    shadow = find_shadow_edges(free, sweep.grazing)
    frontiers = find_frontiers(free, shadow, box)
    return _Stages(np.array([x, y]), free, shadow, frontiers, pieces, owner, distance)


def build_local_map(scan: Scan, state: State, robot: Robot, mapping: LocalMapping) -> LocalMap:
    """The local map from a scan and the pose at its stamp, never from the world. Paper: II-A.

    Obstacles are grown by the robot's radius and `clearance`; the planner then moves a point.
    """
    ranges, first, step = scan.ranges, scan.angle_min + state.yaw, scan.angle_increment
    if step < 0.0:
        ranges, first, step = ranges[::-1], first + step * (len(ranges) - 1), -step
    if step * (len(ranges) - 1) > 2 * math.pi - 0.5 * step:  # the last beam repeats the first
        ranges = ranges[:-1]
    closed = abs(step * len(ranges) - 2 * math.pi) < 0.5 * step
    radius = robot.radius + mapping.clearance
    sweep = Sweep(first, step, closed, scan.range_min, mapping.grazing_angle, mapping.surface_tolerance)
    stages = _build(np.ascontiguousarray(ranges), sweep, radius, mapping.half_side, mapping.n_rays)
    free, frontiers = stages.free, stages.frontiers
    predicted = PREDICTED[mapping.predicted](free, stages.shadow)
    center = state.position + stages.offset
    both_ends = np.concatenate([center, center])
    predicted[:, :2] += center
    return LocalMap(
        stamp=scan.stamp,
        position=center,
        radius=radius,
        half_side=mapping.half_side,
        reach=free.reach,
        border_points=free.border + center,
        surface=free.surface,
        normals=free.normals,
        shadow=stages.shadow,
        segments=frontiers.segments + both_ends,
        frontier_kind=frontiers.kind,
        frontier_number=frontiers.number,
        open_side=frontiers.open_side,
        predicted=predicted,
        walls=stages.pieces + both_ends,
        wall_surface=stages.owner,
        view=stages.distance,
        view_from=np.array([*state.position, first, step]),
    )
