"""The walls that a scan shows and the next one must show too, beam by beam, in the world frame."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.seen import SeenSurfaces, of_each_beam
from collplan_core.scan import Scan

NEAR = 3.0
"""Walls farther than this are not kept: a pose turned by 0.01 rad moves them by more than they are looked for [m]."""
SHORTEST = 0.1
"""Shorter straight pieces are not kept: the noise of a range, 0.01 m, can make them of other surfaces [m]."""
FLATTEST = 0.25
"""Least sine between a beam and a wall."""


def wall_of_each_beam(seen: SeenSurfaces, scan: Scan, position: np.ndarray) -> np.ndarray:
    """(n, 4) where each beam of a scan met a wall, x, y [m], and its normal, towards the sensor; world frame.

    NaN where it met none. Corners, ends, short pieces, lone hits and walls met too flatly are left out: the next scan
    shows them only by chance. `position` (2,) is that of the robot at the stamp of the scan [m].
    """
    return of_each_beam(_walls(seen, position[0], position[1]), scan, math.nan)


@njit
def _walls(seen: SeenSurfaces, x: float, y: float) -> np.ndarray:
    walls = np.full((len(seen.kind), 4), math.nan)
    for i in range(len(walls)):
        k, r = seen.piece_of[i], seen.distance[i]
        if k < 0 or not seen.sweep.range_min < r <= NEAR:
            continue
        along_x, along_y = seen.pieces[k, 2] - seen.pieces[k, 0], seen.pieces[k, 3] - seen.pieces[k, 1]
        length = math.hypot(along_x, along_y)
        if length < SHORTEST:
            continue
        normal_x, normal_y = -along_y / length, along_x / length
        back_x, back_y = -seen.hits[i, 0], -seen.hits[i, 1]
        if len(seen.origins) > 0:
            back_x, back_y = back_x + seen.origins[i, 0], back_y + seen.origins[i, 1]
        facing = back_x * normal_x + back_y * normal_y
        if abs(facing) < FLATTEST * r:
            continue
        side = 1.0 if facing > 0.0 else -1.0
        walls[i, 0], walls[i, 1] = x + seen.hits[i, 0], y + seen.hits[i, 1]
        walls[i, 2], walls[i, 3] = side * normal_x, side * normal_y
    return walls
