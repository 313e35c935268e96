"""Builds the local map from the surfaces in one scan: the stages in order. Paper: II-A."""

from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import FreeSpace, free_space, nearest_free_offset
from collplan_core.local_map.frontiers import Frontiers, find_frontiers, find_shadow_edges
from collplan_core.local_map.predicted import PREDICTED
from collplan_core.local_map.record import LocalMap
from collplan_core.local_map.seen import SeenSurfaces, seen_from, seen_surfaces
from collplan_core.movers.record import ALL_SEEN, ALL_STANDS, SortedReturns, Unseen
from collplan_core.parameters import LocalMapping, Robot
from collplan_core.scan import Scan
from collplan_core.state import State


class _Stages(NamedTuple):
    """Results of the stages, relative to the centre of F, which lies at `offset` (2,) from the robot [m]."""

    offset: np.ndarray
    free: FreeSpace
    shadow: np.ndarray
    frontiers: Frontiers
    pieces: np.ndarray


@njit
def _build(found: SeenSurfaces, radius: float, half_side: float, n_rays: int) -> _Stages:
    """All stages from the surfaces to boundaries, free space and frontiers, in order."""
    x, y = nearest_free_offset(found.pieces, radius)
    box = np.array([-half_side - x, -half_side - y, half_side - x, half_side - y])
    moved = seen_from(found, x, y)
    free = free_space(moved, radius, box, n_rays)
    shadow = find_shadow_edges(free, moved.sweep.grazing)
    return _Stages(np.array([x, y]), free, shadow, find_frontiers(free, shadow, box), moved.pieces)


def build_local_map(
    scan: Scan, state: State, robot: Robot, mapping: LocalMapping, returns: SortedReturns = ALL_STANDS
) -> LocalMap:
    """The local map from a scan and the pose at its stamp, never from the world. Paper: II-A.

    Obstacles are grown by the robot's radius; the planner then moves a point. Each beam begins where
    the sensor was at its instant.
    """
    return map_of_surfaces(seen_surfaces(scan, state), state, robot, mapping, returns)


def map_of_surfaces(
    found: SeenSurfaces,
    state: State,
    robot: Robot,
    mapping: LocalMapping,
    returns: SortedReturns = ALL_STANDS,
    unseen: Unseen = ALL_SEEN,
) -> LocalMap:
    """The local map from the surfaces in a scan, those of movers left out, and the pose at its stamp. Paper: II-A.

    `returns` are the kinds of the scan's returns, `unseen` is what it has out of view.
    """
    stages = _build(found, robot.radius, mapping.half_side, mapping.n_rays)
    free, frontiers = stages.free, stages.frontiers
    predicted = PREDICTED[mapping.predicted](free, stages.shadow)
    center = state.position + stages.offset
    sensor = found.origins[len(found.origins) // 2, :2] if len(found.origins) else 0.0  # in the middle of its sweep
    both_ends = np.concatenate([center, center])
    predicted[:, :2] += center
    return LocalMap(
        stamp=found.stamp,
        position=center,
        radius=robot.radius,
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
        wall_surface=found.owner,
        view=found.distance,
        view_from=np.array([*(state.position + sensor), found.sweep.first, found.sweep.step]),
        view_beams=found.origins + np.array([*state.position, 0.0]),
        returns=returns,
        unseen=unseen,
    )
