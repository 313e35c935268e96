"""Way points of the shortest paths, and what the turns at them cost."""

import math

import numpy as np

from collplan_core.jit import njit

NEAREST = 0.12
"""Way points nearer to each other turn the robot once [m]."""


@njit
def turn_cost(ux: float, uy: float, wx: float, wy: float, max_speed: float, max_acceleration: float) -> float:
    """Time that a turn from direction u to direction w costs [s]."""
    return max_speed * (1.0 - ux * wx - uy * wy) / (2.0 * max_acceleration)


@njit
def way_points(parent: np.ndarray, order: np.ndarray, n: int, my: int, x0: float, y0: float, spacing: float,
               ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """The cells that paths lead to.

    Returns:
        waypoint (mx * my,) int32, number of the way point that a cell's path leads to first, -1 without a path;
        waypoints (w, 2) [m], from near to far; before (w,) int32, the way point that each one's path leads to.
    """
    number = np.full(len(parent), -1, dtype=np.int32)
    for k in range(n):
        number[parent[order[k]]] = 0
    points, before = np.empty((n, 2)), np.empty(n, dtype=np.int32)
    count = 0
    for k in range(n):
        cell = order[k]
        if number[cell] == 0:
            points[count, 0], points[count, 1] = x0 + (cell // my) * spacing, y0 + (cell % my) * spacing
            before[count] = number[parent[cell]] if count else -1
            number[cell] = count
            count += 1
    waypoint = np.full(len(parent), -1, dtype=np.int32)
    for k in range(n):
        waypoint[order[k]] = number[parent[order[k]]]
    return waypoint, points[:count], before[:count]


@njit
def turns(points: np.ndarray, before: np.ndarray, max_speed: float, max_acceleration: float,
          ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """Onward, remaining and turning of a ShortestPaths record.

    A way point nearer than 0.12 m to the one that the path turns at next is none to turn at: counted from the goal, so
    that all paths around a corner turn at the same ones.
    """
    n = len(points)
    onward, remaining, turning = np.full(n, -1, dtype=np.int32), np.zeros(n), np.zeros(n)
    merged = np.zeros(n, dtype=np.bool_)
    for k in range(1, n):
        near = before[k]
        remaining[k] = remaining[near] + math.hypot(points[k, 0] - points[near, 0], points[k, 1] - points[near, 1])
        turn_at = onward[near] if merged[near] else near
        onward[k] = turn_at
        dx, dy = points[turn_at, 0] - points[k, 0], points[turn_at, 1] - points[k, 1]
        distance = math.hypot(dx, dy)
        merged[k] = distance < NEAREST
        after = onward[turn_at]
        turning[k] = turning[turn_at]
        if after >= 0:
            ex, ey = points[after, 0] - points[turn_at, 0], points[after, 1] - points[turn_at, 1]
            rest = math.hypot(ex, ey)
            turning[k] += turn_cost(dx / distance, dy / distance, ex / rest, ey / rest, max_speed, max_acceleration)
    return onward, remaining, turning
