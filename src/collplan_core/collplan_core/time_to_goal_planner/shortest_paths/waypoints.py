"""Waypoints of the shortest paths, and what the turns at them cost.

Around a corner waypoints lie about as close as the cells, with directions as coarse as theirs. Those nearer to each
other than NEAREST are therefore one turn, from the direction in which the path comes to that in which it leaves.
"""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.shortest_paths.grid import Cells

NEAREST = 0.125
"""Waypoints nearer to each other than this are one turn; between two lengths that the cells make often [m]."""
ONE_TURN = math.pi / 3.0
"""A larger turn counts as several, of this angle and what is left: a robot takes it so [rad]."""
NONE, UNNUMBERED = -1, -2
COS, SIN = math.cos(ONE_TURN), math.sin(ONE_TURN)


@njit
def turn(cosine: float) -> float:
    """1 - cos, summed over the turns that count instead of a turn with this cosine."""
    total, cosine = 0.0, min(cosine, 1.0)
    while cosine < COS:
        cosine = cosine * COS + math.sqrt(max(1.0 - cosine * cosine, 0.0)) * SIN
        total += 1.0 - COS
    return total + 1.0 - cosine


@njit
def find_waypoints(
    parent: np.ndarray, order: np.ndarray, cells: Cells, goal: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The waypoints of all paths: cells at which some path turns or ends.

    Returns waypoint (mx * my,) int32, number of the waypoint that a cell's path leads to first, -1 without a path;
    waypoints (w, 2) [m], from near to far; before (w,) int32, the waypoint that each one's path leads to.

    Args:
        parent: (mx * my,) flat index of the cell that the path leads to from each.
        order: (n,) the cells that have a path, from near to far.
        goal: the cell that all paths end at.
    """
    my = cells.blocked.shape[1]
    number = np.full(len(parent), NONE, dtype=np.int32)
    for cell in order:
        number[parent[cell]] = UNNUMBERED
    places, before = np.empty(len(order) + 1, dtype=np.int32), np.empty(len(order) + 1, dtype=np.int32)
    places[0], before[0], number[goal] = goal, NONE, 0
    count = 1
    for cell in order:
        if number[cell] == UNNUMBERED:
            places[count], before[count], number[cell] = cell, number[parent[cell]], count
            count += 1
    waypoint = np.full(len(parent), NONE, dtype=np.int32)
    for cell in order:
        waypoint[cell] = number[parent[cell]]
    points = np.empty((count, 2))
    points[:, 0] = cells.x + cells.spacing * (places[:count] // my)
    points[:, 1] = cells.y + cells.spacing * (places[:count] % my)
    return waypoint, points, before[:count]


@njit
def _earlier(ex: float, ey: float, left: float) -> tuple[float, float]:
    """Direction e before the last ONE_TURN of a turn to the left (left > 0) or right."""
    side = math.copysign(SIN, left)
    return COS * ex + side * ey, COS * ey - side * ex


@njit
def turns(points: np.ndarray, before: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Onward, remaining and turning of a ShortestPaths record."""
    n = len(points)
    onward, remaining, turning = np.zeros((n, 2)), np.zeros(n), np.zeros(n)
    legs, left = np.zeros((n, 2)), np.zeros(n)
    for k in range(1, n):
        toward = before[k]
        dx, dy = points[toward, 0] - points[k, 0], points[toward, 1] - points[k, 1]
        leg = math.hypot(dx, dy)
        ux, uy = dx / leg, dy / leg
        ex, ey = onward[toward]
        legs[k, 0], legs[k, 1] = ux, uy
        remaining[k] = remaining[toward] + leg
        turning[k] = turning[toward]
        if toward == 0 or leg >= NEAREST:
            turning[k] += turn(ux * ex + uy * ey) if toward > 0 else 0.0
            onward[k, 0], onward[k, 1] = ux, uy
            continue
        wx, wy = legs[toward]
        left[k] = left[toward] + math.atan2(ux * wy - uy * wx, ux * wx + uy * wy)
        while abs(left[k]) > ONE_TURN:
            ex, ey = _earlier(ex, ey, left[k])
            left[k] -= math.copysign(ONE_TURN, left[k])
            turning[k] += 1.0 - COS
        onward[k, 0], onward[k, 1] = ex, ey
    return onward, remaining, turning
