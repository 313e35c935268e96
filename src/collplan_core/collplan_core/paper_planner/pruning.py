"""Pruning of candidates by frontier and by direction, before the product is built. Paper: II-C."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import inside


@njit
def free_sight(border: np.ndarray, ax: float, ay: float, bx: float, by: float) -> bool:
    """Returns whether the straight line between two points of F (relative to its centre) stays in F."""
    n = max(2, int(math.hypot(bx - ax, by - ay) / 0.01))
    for i in range(1, n):
        share = i / n
        if not inside(border, ax + share * (bx - ax), ay + share * (by - ay)):
            return False
    return True


@njit
def is_represented_by(
    border: np.ndarray, positions: np.ndarray, frontier_of: np.ndarray, a: int, b: int, distance: float
) -> bool:
    """Returns whether some position of frontier b is within distance of one of frontier a, across free space."""
    for i in range(len(positions)):
        if frontier_of[i] != a:
            continue
        for j in range(len(positions)):
            if frontier_of[j] != b:
                continue
            if math.hypot(positions[i, 0] - positions[j, 0], positions[i, 1] - positions[j, 1]) > distance:
                continue
            if free_sight(border, positions[i, 0], positions[i, 1], positions[j, 0], positions[j, 1]):
                return True
    return False


@njit
def prune_positions(
    border: np.ndarray, positions: np.ndarray, frontier_of: np.ndarray, goal: np.ndarray, distance: float
) -> np.ndarray:
    """(p,) which positions stay: a frontier is dropped where one near it and nearer to the goal stands for it.

    Position-based pruning. A dropped frontier drops no other, so the one nearest to the goal always stays. Border
    points (n, 2) of F, sampled positions (p, 2) and the goal (2,), p_goal, are relative to the centre of F [m];
    `frontier_of` (p,) is the frontier of each position, rising from 0; `distance` is d_prune [m].
    """
    n = frontier_of[-1] + 1 if len(frontier_of) else 0
    nearest = np.full(n, math.inf)
    for i in range(len(positions)):
        to_goal = math.hypot(goal[0] - positions[i, 0], goal[1] - positions[i, 1])
        nearest[frontier_of[i]] = min(nearest[frontier_of[i]], to_goal)
    stays = np.ones(n, np.bool_)
    order = np.argsort(nearest, kind="mergesort")
    for rank in range(1, n):
        for earlier in range(rank):
            a, b = order[rank], order[earlier]
            if (
                stays[b]
                and nearest[b] < nearest[a]
                and is_represented_by(border, positions, frontier_of, a, b, distance)
            ):
                stays[a] = False
                break
    kept = np.empty(len(positions), np.bool_)
    for i in range(len(positions)):
        kept[i] = stays[frontier_of[i]]
    return kept


@njit
def prune_directions(segments: np.ndarray, n_directions: int) -> np.ndarray:
    """(m, n_directions) which directions stay: on each frontier segment only those that lead into unseen space.

    Velocity-direction-based pruning. F lies on the left of a segment (m, 4), unseen space on its right. Where no
    direction is left, all stay.
    """
    kept = np.zeros((len(segments), n_directions), np.bool_)
    for k in range(len(segments)):
        dx, dy = segments[k, 2] - segments[k, 0], segments[k, 3] - segments[k, 1]
        length = max(math.hypot(dx, dy), 1e-12)
        for direction in range(n_directions):
            theta = 2.0 * math.pi * direction / n_directions
            kept[k, direction] = (math.cos(theta) * dy - math.sin(theta) * dx) / length > 1e-6
        if not kept[k].any():
            kept[k] = True
    return kept
