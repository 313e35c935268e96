"""Builds the local map from one scan and its pose: the stages in order. Paper: II-A."""

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
from collplan_core.plane import rotate_rows
from collplan_core.scan import Scan
from collplan_core.sight_lines import repeats_first
from collplan_core.state import State


class _Stages(NamedTuple):
    """Results of the stages, relative to the centre of F, which lies at `offset` (2,) from the robot [m]."""

    offset: np.ndarray
    free: FreeSpace
    shadow: np.ndarray
    frontiers: Frontiers
    pieces: np.ndarray
    owner: np.ndarray
    distance: np.ndarray


@njit
def _build(
    ranges: np.ndarray, sweep: Sweep, beams: np.ndarray, radius: float, half_side: float, n_rays: int
) -> _Stages:
    """All stages from the ranges of a sweep (b,) [m] to boundaries, free space and frontiers, in order."""
    kind, distance = beam_kinds(ranges, sweep.range_min)
    hits = np.zeros((len(ranges), 2))
    for i in range(len(ranges)):
        if kind[i] == HIT:
            bearing = sweep.first + i * sweep.step
            if len(beams) > 0:
                bearing += beams[i, 2]
            hits[i, 0] = distance[i] * math.cos(bearing)
            hits[i, 1] = distance[i] * math.sin(bearing)
            if len(beams) > 0:
                hits[i, 0] += beams[i, 0]
                hits[i, 1] += beams[i, 1]
    joined = find_surfaces(kind, distance, hits, sweep)
    pieces, owner, surface_of = fit_pieces(kind, hits, joined, sweep.tolerance)
    x, y = nearest_free_offset(pieces, radius)
    box = np.array([-half_side - x, -half_side - y, half_side - x, half_side - y])
    for k in range(len(pieces)):
        pieces[k, 0] -= x
        pieces[k, 1] -= y
        pieces[k, 2] -= x
        pieces[k, 3] -= y
    origins = beams - np.array([x, y, 0.0])
    seen = Beams(kind, distance, joined, surface_of, origins)
    free = free_space(pieces, owner, seen, sweep, radius, box, n_rays)
    shadow = find_shadow_edges(free, sweep.grazing)
    frontiers = find_frontiers(free, shadow, box)
    return _Stages(np.array([x, y]), free, shadow, frontiers, pieces, owner, distance)


def build_local_map(scan: Scan, state: State, robot: Robot, mapping: LocalMapping) -> LocalMap:
    """The local map from a scan and the pose at its stamp, never from the world. Paper: II-A.

    Obstacles are grown by the robot's radius and `clearance`; the planner then moves a point. Each beam begins where
    the sensor was at its instant.
    """
    ranges, first, step = scan.ranges, scan.angle_min + state.yaw, scan.angle_increment
    beams = _around_robot(scan, state)
    if step < 0.0:
        ranges, first, step, beams = ranges[::-1], first + step * (len(ranges) - 1), -step, beams[::-1]
    if repeats_first(len(ranges), step):
        ranges, beams = ranges[:-1], beams[: len(ranges) - 1]
    closed = abs(step * len(ranges) - 2 * math.pi) < 0.5 * step
    radius = robot.radius + mapping.clearance
    sweep = Sweep(first, step, closed, scan.range_min, mapping.grazing_angle, mapping.surface_tolerance)
    beams = np.ascontiguousarray(beams)
    stages = _build(np.ascontiguousarray(ranges), sweep, beams, radius, mapping.half_side, mapping.n_rays)
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
        view_from=np.array([*(state.position + _middle(beams)), first, step]),
        view_beams=beams + np.array([*state.position, 0.0]),
    )


def _around_robot(scan: Scan, state: State) -> np.ndarray:
    """(n, 3) x, y [m], seen from the robot's centre along the world's axes, and yaw [rad], seen from the robot's.

    Of the sensor at each beam; (0, 3) where it is at the robot's centre all the time.
    """
    if scan.sensor_poses is None:
        return np.zeros((0, 3))
    return np.column_stack([rotate_rows(scan.sensor_poses[:, :2], state.yaw), scan.sensor_poses[:, 2]])


def _middle(beams: np.ndarray) -> np.ndarray:
    """(2,) where the sensor was in the middle of its sweep [m]."""
    return beams[len(beams) // 2, :2] if len(beams) else np.zeros(2)
