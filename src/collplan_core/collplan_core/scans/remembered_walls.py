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
LEAST = 0.5
"""Pieces with less than this on one line in all are no walls: a leg that stands for a step is one, and walks on [m]."""
ON_LINE = 0.03
"""A piece is on the line of another within this distance, at both ends [m]."""
FLATTEST = 0.25
"""Least sine between a beam and a wall."""


def wall_of_each_beam(seen: SeenSurfaces, scan: Scan, position: np.ndarray) -> np.ndarray:
    """(n, 5) where each beam of a scan met what stands, x, y [m], its normal, and 1 for a wall, 0 for what is shorter.

    The normal is towards the sensor. World frame; NaN where it met nothing. Corners, ends, short pieces, lone hits and
    walls met too flatly are left out: the next scan shows them only by chance. A wall may be seen in pieces, between
    posts. `position` (2,) is that of the robot at the stamp of the scan [m].
    """
    return of_each_beam(_walls(seen, position[0], position[1]), scan, math.nan)


@njit
def _walls(seen: SeenSurfaces, x: float, y: float) -> np.ndarray:
    walls, extents = np.full((len(seen.kind), 5), math.nan), _extents(seen.pieces)
    for i in range(len(walls)):
        k, r = seen.piece_of[i], seen.distance[i]
        if k < 0 or not seen.sweep.range_min < r <= NEAR:
            continue
        along_x, along_y = seen.pieces[k, 2] - seen.pieces[k, 0], seen.pieces[k, 3] - seen.pieces[k, 1]
        length = math.hypot(along_x, along_y)
        if extents[k] == 0.0:
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
        walls[i, 2], walls[i, 3], walls[i, 4] = side * normal_x, side * normal_y, extents[k] >= LEAST
    return walls


@njit
def _extents(pieces: np.ndarray) -> np.ndarray:
    """(m,) length of the pieces that lie on the line of each, its own with them [m]; 0 for a piece below SHORTEST."""
    lengths = np.hypot(pieces[:, 2] - pieces[:, 0], pieces[:, 3] - pieces[:, 1])
    lengths[lengths < SHORTEST] = 0.0
    extents = lengths.copy()
    for k in range(len(pieces)):
        for i in range(k):
            if lengths[k] > 0.0 and lengths[i] > 0.0 and _on_one_line(pieces, lengths, i, k):
                extents[k], extents[i] = extents[k] + lengths[i], extents[i] + lengths[k]
    return extents


@njit
def _on_one_line(pieces: np.ndarray, lengths: np.ndarray, i: int, k: int) -> bool:
    """Whether both ends of the shorter piece are on the line of the longer one."""
    long, short = (k, i) if lengths[k] >= lengths[i] else (i, k)
    x, y, length = pieces[long, 0], pieces[long, 1], lengths[long]
    dx, dy = (pieces[long, 2] - x) / length, (pieces[long, 3] - y) / length
    first = (pieces[short, 0] - x) * dy - (pieces[short, 1] - y) * dx
    last = (pieces[short, 2] - x) * dy - (pieces[short, 3] - y) * dx
    return max(abs(first), abs(last)) <= ON_LINE
