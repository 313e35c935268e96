"""The time to go from a state, looked up in the shortest paths."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_go.record import ShortestPaths
from collplan_core.time_to_go.waypoints import turn_cost

TURNING_IN = 0.3
"""A way point nearer than this may already be turned at [m]."""
RINGS = 3
"""From within a known obstacle the path begins at the nearest free cell, at most so many cells away."""


@njit
def _time_by(k: int, waypoints: np.ndarray, onward: np.ndarray, remaining: np.ndarray, turning: np.ndarray,
             max_speed: float, max_acceleration: float, x: float, y: float, vx: float, vy: float,
             ) -> float:  # fmt: skip
    """Time to go from (x, y) at (vx, vy) with way point k the first one [s]."""
    dx, dy = waypoints[k, 0] - x, waypoints[k, 1] - y
    distance = math.hypot(dx, dy)
    base = (distance + remaining[k]) / max_speed + turning[k]
    after = onward[k]
    ux, uy = (dx / distance, dy / distance) if distance > 1e-9 else (0.0, 0.0)
    if after < 0:
        return base + _swing(ux, uy, max_speed, max_acceleration, vx, vy)
    ex, ey = waypoints[after, 0] - waypoints[k, 0], waypoints[after, 1] - waypoints[k, 1]
    rest = math.hypot(ex, ey)
    wx, wy = ex / rest, ey / rest
    turned = base + _swing(wx, wy, max_speed, max_acceleration, vx, vy)
    if distance <= 1e-9:
        return turned
    ahead = base + _swing(ux, uy, max_speed, max_acceleration, vx, vy)
    ahead += turn_cost(ux, uy, wx, wy, max_speed, max_acceleration)
    return min(ahead, turned) if distance < TURNING_IN else ahead


@njit
def _swing(ux: float, uy: float, max_speed: float, max_acceleration: float, vx: float, vy: float) -> float:
    """Time that it costs not to move at full speed along u already [s]."""
    return ((max_speed * ux - vx) ** 2 + (max_speed * uy - vy) ** 2) / (2.0 * max_acceleration * max_speed)


@njit
def first_cell(x: float, origin: float, spacing: float, count: int) -> int:
    """Index of the cell before x along an axis such that both it and the one after it exist."""
    return min(max(int(math.floor((x - origin) / spacing)), 0), count - 2)


@njit
def _nearest_ring(waypoint: np.ndarray, ox: float, oy: float, spacing: float, x: float, y: float,
                  ) -> tuple[int, int, int, int]:  # fmt: skip
    """Cells [i0, i1) x [j0, j1) around (x, y): the four around it or, if no path leads from these, wider by rings."""
    mx, my = waypoint.shape
    i, j = first_cell(x, ox, spacing, mx), first_cell(y, oy, spacing, my)
    for ring in range(RINGS + 1):
        i0, i1, j0, j1 = max(i - ring, 0), min(i + 2 + ring, mx), max(j - ring, 0), min(j + 2 + ring, my)
        for a in range(i0, i1):
            for b in range(j0, j1):
                if waypoint[a, b] >= 0:
                    return i0, i1, j0, j1
    return 0, 0, 0, 0


@njit
def time_to_go(length: np.ndarray, waypoint: np.ndarray, waypoints: np.ndarray, onward: np.ndarray,
               remaining: np.ndarray, turning: np.ndarray, ox: float, oy: float, spacing: float,
               goal_x: float, goal_y: float, tolerance: float, max_speed: float, max_acceleration: float,
               x: float, y: float, vx: float, vy: float) -> float:  # fmt: skip
    """Time from (x, y) at (vx, vy) to the goal, inf where no path leads there, 0 within its tolerance [s].

    The arrays and the numbers up to tolerance are those of ShortestPaths.
    """
    if (x - goal_x) ** 2 + (y - goal_y) ** 2 <= tolerance * tolerance:
        return 0.0
    i0, i1, j0, j1 = _nearest_ring(waypoint, ox, oy, spacing, x, y)
    best, last = np.inf, -1
    for i in range(i0, i1):
        for j in range(j0, j1):
            k = waypoint[i, j]
            if k >= 0 and k != last:
                last = k
                time = _time_by(k, waypoints, onward, remaining, turning, max_speed, max_acceleration, x, y, vx, vy)
                best = min(best, time)
    return best


@njit
def heading(length: np.ndarray, waypoint: np.ndarray, waypoints: np.ndarray, onward: np.ndarray,
            remaining: np.ndarray, turning: np.ndarray, ox: float, oy: float, spacing: float,
            goal_x: float, goal_y: float, tolerance: float, x: float, y: float,
            ) -> tuple[float, float, float]:  # fmt: skip
    """Unit direction from (x, y) to the first way point of the shortest path and the distance to it [m].

    (0, 0) and inf where no path leads to the goal.
    """
    best, chosen = np.inf, -1
    i0, i1, j0, j1 = _nearest_ring(waypoint, ox, oy, spacing, x, y)
    for i in range(i0, i1):
        for j in range(j0, j1):
            k = waypoint[i, j]
            if k >= 0:
                total = math.hypot(waypoints[k, 0] - x, waypoints[k, 1] - y) + remaining[k]
                if total < best:
                    best, chosen = total, k
    if chosen < 0:
        return 0.0, 0.0, np.inf
    dx, dy = waypoints[chosen, 0] - x, waypoints[chosen, 1] - y
    distance = math.hypot(dx, dy)
    if distance <= 1e-9 and onward[chosen] >= 0:
        after = onward[chosen]
        dx, dy = waypoints[after, 0] - x, waypoints[after, 1] - y
        distance = math.hypot(dx, dy)
    return (dx / distance, dy / distance, distance) if distance > 1e-9 else (0.0, 0.0, 0.0)


def is_reachable(paths: ShortestPaths, position: np.ndarray) -> bool:
    """Whether a path leads from position (2,) to the goal."""
    x, y = float(position[0]), float(position[1])
    if np.hypot(*(paths.goal - position)) <= paths.tolerance:
        return True
    i0, i1, _, _ = _nearest_ring(paths.waypoint, float(paths.origin[0]), float(paths.origin[1]), paths.spacing, x, y)
    return bool(i1 > i0)
