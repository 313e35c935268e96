"""Which candidates are never built. Paper: II-C. Decided by frontier and by direction, before the product is formed."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import inside


@njit
def free_sight(ends: np.ndarray, ax: float, ay: float, bx: float, by: float) -> bool:
    """Whether the straight line between two points of F (relative to its centre) stays in F."""
    n = max(2, int(math.hypot(bx - ax, by - ay) / 0.01))
    for i in range(1, n):
        share = i / n
        if not inside(ends, ax + share * (bx - ax), ay + share * (by - ay)):
            return False
    return True


@njit
def is_represented_by(
    ends: np.ndarray, positions: np.ndarray, member: np.ndarray, a: int, b: int, distance: float
) -> bool:
    """Whether some position of frontier b is within distance of one of frontier a, across free space."""
    for i in range(len(positions)):
        if member[i] != a:
            continue
        for j in range(len(positions)):
            if (
                member[j] != b
                or math.hypot(positions[i, 0] - positions[j, 0], positions[i, 1] - positions[j, 1]) > distance
            ):
                continue
            if free_sight(ends, positions[i, 0], positions[i, 1], positions[j, 0], positions[j, 1]):
                return True
    return False


@njit
def prune_positions(
    ends: np.ndarray, positions: np.ndarray, member: np.ndarray, gx: float, gy: float, distance: float
) -> np.ndarray:
    """Position-based pruning: a frontier is dropped where a nearby one that is nearer to the goal stands for it.

    A dropped frontier drops nobody, so the one nearest to the goal always stays. Points relative to the centre of F.

    Args:
        positions: (p, 2) sampled positions [m].
        member: (p,) frontier of each, rising from 0.
        gx, gy: goal [m].
        distance: d_prune [m].

    Returns:
        (p,) which positions stay.
    """
    n = member[-1] + 1 if len(member) else 0
    best = np.full(n, math.inf)
    for i in range(len(positions)):
        best[member[i]] = min(best[member[i]], math.hypot(gx - positions[i, 0], gy - positions[i, 1]))
    stays = np.ones(n, np.bool_)
    order = np.argsort(best, kind="mergesort")
    for rank in range(1, n):
        for earlier in range(rank):
            a, b = order[rank], order[earlier]
            if stays[b] and best[b] < best[a] and is_represented_by(ends, positions, member, a, b, distance):
                stays[a] = False
                break
    kept = np.empty(len(positions), np.bool_)
    for i in range(len(positions)):
        kept[i] = stays[member[i]]
    return kept


@njit
def prune_directions(segments: np.ndarray, n_directions: int) -> np.ndarray:
    """Velocity-direction-based pruning: on each frontier piece only directions that lead into unseen space stay.

    F lies on the left of a piece, unseen space on its right. Where no direction is left, all stay.

    Returns:
        (m, n_directions) which directions stay.
    """
    heads = np.zeros((len(segments), n_directions), np.bool_)
    for k in range(len(segments)):
        dx, dy = segments[k, 2] - segments[k, 0], segments[k, 3] - segments[k, 1]
        length = max(math.hypot(dx, dy), 1e-12)
        for head in range(n_directions):
            theta = 2.0 * math.pi * head / n_directions
            heads[k, head] = (math.cos(theta) * dy - math.sin(theta) * dx) / length > 1e-6
        if not heads[k].any():
            heads[k] = True
    return heads
