"""A way that leads from node to node of a clearance field: narrower than the cells of the shortest paths can show."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import ClearanceField, Grid
from collplan_core.time_to_goal_planner.boundary_memory.refined import UNSURE

WITHIN = 0.10
"""A robot measured inside a boundary begins at the free node that is nearest to it, at most so far away [m]."""


def narrow_way(field: ClearanceField, position: np.ndarray, goal: np.ndarray, tolerance: float) -> np.ndarray | None:
    """Places (n, 2) [m] on the way of fewest nodes to a goal (2,) [m], each free and beside the next; None without one.

    It ends at the goal, straight on once within the tolerance [m], or at the edge of the field if that lies beyond.
    """
    way = _leading(field, position, goal, tolerance, 0.0)
    if len(way) == 0:
        return None
    rest = float(np.hypot(*(goal - way[-1])))
    if rest > tolerance + field.spacing:
        return way
    return np.vstack([way, np.linspace(way[-1], goal, 2 + int(rest / field.spacing))])


def may_lead(field: ClearanceField, position: np.ndarray, goal: np.ndarray, tolerance: float) -> bool:
    """Whether a way may lead to a goal (2,) [m] between the nodes; where it says no, finer nodes hold none either."""
    reach, lowest = tolerance + field.spacing, -UNSURE * field.spacing
    return len(_leading(field, position, goal, reach, lowest)) > 0


def _leading(
    field: ClearanceField, position: np.ndarray, goal: np.ndarray, tolerance: float, lowest: float
) -> np.ndarray:
    x, y, goal_x, goal_y = (float(value) for value in (*position, *goal))
    way: np.ndarray = _way(field.clearance, field.grid, x, y, goal_x, goal_y, tolerance, lowest)
    return way


@njit
def _nearest_free(clearance: np.ndarray, grid: Grid, x: float, y: float, lowest: float) -> int:
    """Flat index of the node nearest to (x, y) with a clearance from `lowest` up, -1 where none is within reach.

    From beyond the nodes, where nothing is known, their edge counts as there.
    """
    nx, ny = clearance.shape
    fx = min(max((x - grid.x) / grid.spacing, 0.0), nx - 1.0)
    fy = min(max((y - grid.y) / grid.spacing, 0.0), ny - 1.0)
    reach = WITHIN / grid.spacing
    nearest, least = -1, reach * reach
    for i in range(max(0, int(math.ceil(fx - reach))), min(nx, int(math.floor(fx + reach)) + 1)):
        for j in range(max(0, int(math.ceil(fy - reach))), min(ny, int(math.floor(fy + reach)) + 1)):
            away = (i - fx) * (i - fx) + (j - fy) * (j - fy)
            if away <= least and clearance[i, j] >= lowest:
                nearest, least = i * ny + j, away
    return nearest


@njit
def _way(
    clearance: np.ndarray,
    grid: Grid,
    x: float,
    y: float,
    goal_x: float,
    goal_y: float,
    tolerance: float,
    lowest: float,
) -> np.ndarray:
    """(n, 2) the nodes on the way, (0, 2) where there is none: spreads over those with a clearance from `lowest` up."""
    nx, ny = clearance.shape
    gx, gy, reach = (goal_x - grid.x) / grid.spacing, (goal_y - grid.y) / grid.spacing, tolerance / grid.spacing
    outside = not (0.0 <= gx <= nx - 1 and 0.0 <= gy <= ny - 1)
    before, queue = np.full(nx * ny, -1, np.int32), np.empty(nx * ny, np.int32)
    start = _nearest_free(clearance, grid, x, y, lowest)
    taken, count = 0, 0
    if start >= 0:
        before[start], queue[0], count = start, start, 1
    while taken < count:
        node = queue[taken]
        taken += 1
        i, j = node // ny, node % ny
        if outside:
            there = i == 0 or j == 0 or i == nx - 1 or j == ny - 1
        else:
            there = (i - gx) * (i - gx) + (j - gy) * (j - gy) <= reach * reach
        if there:
            return _back_from(before, node, ny, grid)
        for a in range(max(i - 1, 0), min(i + 2, nx)):
            for b in range(max(j - 1, 0), min(j + 2, ny)):
                neighbour = a * ny + b
                if before[neighbour] < 0 and clearance[a, b] >= lowest:
                    before[neighbour], queue[count] = node, neighbour
                    count += 1
    return np.empty((0, 2))


@njit
def _back_from(before: np.ndarray, last: int, ny: int, grid: Grid) -> np.ndarray:
    """(n, 2) places of the nodes that lead to the last one, in order [m]."""
    n, node = 1, last
    while before[node] != node:
        n, node = n + 1, before[node]
    way, node = np.empty((n, 2)), last
    for k in range(n - 1, -1, -1):
        way[k, 0], way[k, 1] = grid.x + (node // ny) * grid.spacing, grid.y + (node % ny) * grid.spacing
        node = before[node]
    return way
