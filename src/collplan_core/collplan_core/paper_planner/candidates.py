"""The parts of the sampling configuration space C = S x Theta x V. Paper: II-A."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.velocity_bounds import VelocityBounds, fastest_along


@njit
def long_enough(segments: np.ndarray, number: np.ndarray, shortest: float) -> np.ndarray:
    """(m,) which segments (m, 4) are of frontiers at least so long [m]; all of them where none is.

    Between two touching round obstacles a notch of a few centimetres is seen as a frontier; to aim at it is to creep.
    The segments are straight [m]; `number` (m,) is the frontier of each.
    """
    length = np.zeros(number[-1] + 1 if len(number) else 0)
    for k in range(len(segments)):
        length[number[k]] += math.hypot(segments[k, 2] - segments[k, 0], segments[k, 3] - segments[k, 1])
    kept = np.empty(len(segments), np.bool_)
    for k in range(len(segments)):
        kept[k] = length[number[k]] >= shortest
    return kept if kept.any() else np.ones(len(segments), np.bool_)


@njit
def sample_positions(segments: np.ndarray, number: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """S: floor(length(B_i) / dl) positions on each frontier B_i (printed for N_v), at least one.

    Returns positions (p, 2) [m] and the segment each lies on (p,). They lie at the centres of equal cells, never at a
    frontier's ends, where the distance to a predicted boundary is 0 by construction. The segments (m, 4) are straight,
    those of one frontier in sequence [m]; `number` (m,) is the frontier of each; `spacing` is dl [m].
    """
    m = len(segments)
    length = np.empty(m)
    total = 0.0
    for k in range(m):
        length[k] = math.hypot(segments[k, 2] - segments[k, 0], segments[k, 3] - segments[k, 1])
        total += length[k]
    positions = np.empty((m + int(total / spacing), 2))
    segment_of = np.empty(len(positions), np.int64)
    count, first = 0, 0
    while first < m:
        last = first
        frontier_length = length[first]
        while last + 1 < m and number[last + 1] == number[first]:
            last += 1
            frontier_length += length[last]
        cells = max(1, int(math.floor(frontier_length / spacing + 1e-9)))
        k, before = first, 0.0
        for i in range(cells):
            along = (i + 0.5) * frontier_length / cells
            while k < last and along > before + length[k]:
                before += length[k]
                k += 1
            share = (along - before) / max(length[k], 1e-12)
            positions[count, 0] = segments[k, 0] + share * (segments[k, 2] - segments[k, 0])
            positions[count, 1] = segments[k, 1] + share * (segments[k, 3] - segments[k, 1])
            segment_of[count] = k
            count += 1
        first = last + 1
    return positions[:count], segment_of[:count]


def fixed_speed_counts(frontier_of: np.ndarray, n_speeds: int) -> np.ndarray:
    """N_v of each position (p,): `n_speeds`, on whatever frontier (p,) it lies."""
    return np.full(len(frontier_of), n_speeds)


def printed_speed_counts(frontier_of: np.ndarray, n_speeds: int) -> np.ndarray:
    """N_v = floor(length(B_i) / dl) of each position (p,), as printed: the number of positions on its frontier (p,)."""
    return np.bincount(frontier_of)[frontier_of]


SPEED_COUNTS = {"fixed": fixed_speed_counts, "printed": printed_speed_counts}
"""N_v by planner.speeds."""


@njit
def product(
    directions: np.ndarray, segment_of: np.ndarray, n_speeds: np.ndarray, bounds: VelocityBounds
) -> tuple[np.ndarray, np.ndarray]:
    """The candidates: each position at rest once, then every kept direction at every speed.

    Returns the index of each one's position (c,) and its velocity (c, 2) [m/s]. `directions` (m, N_l) says which theta
    are kept on each frontier segment, `segment_of` (p,) is the segment and `n_speeds` (p,) the N_v of each position;
    `bounds` are v_max by direction.
    """
    n_directions = directions.shape[1]
    size = 0
    for i in range(len(segment_of)):
        size += 1 + n_speeds[i] * int(directions[segment_of[i]].sum())
    position_of = np.empty(size, np.int64)
    velocities = np.zeros((size, 2))
    c = 0
    for i in range(len(segment_of)):
        position_of[c] = i
        c += 1
        for direction in range(n_directions):
            if not directions[segment_of[i], direction]:
                continue
            theta = 2.0 * math.pi * direction / n_directions
            x, y = math.cos(theta), math.sin(theta)
            most = fastest_along(bounds, x, y)
            for step in range(1, n_speeds[i] + 1):
                speed = most * step / n_speeds[i]
                position_of[c] = i
                velocities[c, 0], velocities[c, 1] = speed * x, speed * y
                c += 1
    return position_of, velocities
