"""The time to go from a state, looked up in the shortest paths."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.waypoints import NEAREST, turn

EARLY, LATE = 0.2, 0.4
"""The turn at a way point nearer than the first may have been made already; beyond the second it has not [m]."""
RINGS = 3
"""From within a known obstacle the path begins at the nearest free cells, at most so many cells away."""


@njit
def _ahead(k: int, waypoints: np.ndarray, onward: np.ndarray, x: float, y: float) -> tuple[float, float, float]:
    """Unit direction from (x, y) along the path by way point k, and the distance to that [m].

    Toward a point NEAREST ahead on the path: so close to a way point the direction to it says nothing.
    """
    dx, dy = waypoints[k, 0] - x, waypoints[k, 1] - y
    distance = math.hypot(dx, dy)
    beyond = max(NEAREST - distance, 0.0)
    dx, dy = dx + beyond * onward[k, 0], dy + beyond * onward[k, 1]
    far = math.hypot(dx, dy)
    if far < 1e-9:
        return onward[k, 0], onward[k, 1], distance
    return dx / far, dy / far, distance


@njit
def _swing(ux: float, uy: float, max_speed: float, max_acceleration: float, vx: float, vy: float) -> float:
    """Time that it costs not to move at full speed along u already [s]."""
    return ((max_speed * ux - vx) ** 2 + (max_speed * uy - vy) ** 2) / (2.0 * max_acceleration * max_speed)


@njit
def _time_by(k: int, waypoints: np.ndarray, onward: np.ndarray, remaining: np.ndarray, turning: np.ndarray,
             max_speed: float, max_acceleration: float, x: float, y: float, vx: float, vy: float,
             ) -> float:  # fmt: skip
    """Time to go from (x, y) at (vx, vy) with way point k the first one [s].

    The velocity has to become that toward the way point, which then turns there. Or it has that turn behind it and has
    to become the one onward, if that is faster: wholly up to EARLY from the way point, by less and less up to LATE.
    """
    ux, uy, distance = _ahead(k, waypoints, onward, x, y)
    time = (distance + remaining[k]) / max_speed
    before = _swing(ux, uy, max_speed, max_acceleration, vx, vy)
    if k == 0:
        return time + before
    wx, wy = onward[k]
    cost = 0.5 * max_speed / max_acceleration
    before += cost * turn(ux * wx + uy * wy)
    behind = _swing(wx, wy, max_speed, max_acceleration, vx, vy)
    share = min(max((LATE - distance) / (LATE - EARLY), 0.0), 1.0)
    return time + cost * turning[k] + before - share * max(before - behind, 0.0)


@njit
def _before(along: float, count: int) -> int:
    """Cell before a place on an axis [cells], such that it and the one after it exist."""
    return min(max(int(math.floor(along)), 0), count - 2)


@njit
def _cells_near(waypoint: np.ndarray, ox: float, oy: float, spacing: float, x: float, y: float,
                ) -> tuple[int, int, int, int]:  # fmt: skip
    """Cells [i0, i1) x [j0, j1): the four around (x, y) or, where these have no path, so many rings more; or none."""
    mx, my = waypoint.shape
    i, j = _before((x - ox) / spacing, mx), _before((y - oy) / spacing, my)
    for ring in range(RINGS + 1):
        i0, i1, j0, j1 = max(i - ring, 0), min(i + 2 + ring, mx), max(j - ring, 0), min(j + 2 + ring, my)
        for a in range(i0, i1):
            for b in range(j0, j1):
                if waypoint[a, b] >= 0:
                    return i0, i1, j0, j1
    return 0, 0, 0, 0


@njit
def time_to_go(waypoint: np.ndarray, waypoints: np.ndarray, onward: np.ndarray, remaining: np.ndarray,
               turning: np.ndarray, ox: float, oy: float, spacing: float, goal_x: float, goal_y: float,
               tolerance: float, max_speed: float, max_acceleration: float, x: float, y: float, vx: float, vy: float,
               ) -> float:  # fmt: skip
    """Time from (x, y) at (vx, vy) to the goal, inf where no path leads there, 0 within its tolerance [s].

    Arguments up to tolerance are those of ShortestPaths. Of the way points that the four cells around lead to, the
    one that is best counts: there is no step where one cell ends.
    """
    if (x - goal_x) ** 2 + (y - goal_y) ** 2 <= tolerance * tolerance:
        return 0.0
    i0, i1, j0, j1 = _cells_near(waypoint, ox, oy, spacing, x, y)
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
def heading(waypoint: np.ndarray, waypoints: np.ndarray, onward: np.ndarray, remaining: np.ndarray, ox: float,
            oy: float, spacing: float, x: float, y: float) -> tuple[float, float, float]:  # fmt: skip
    """Unit direction from (x, y) along the shortest path and the distance to its first way point [m].

    (0, 0) and inf where no path leads to the goal.
    """
    i0, i1, j0, j1 = _cells_near(waypoint, ox, oy, spacing, x, y)
    best, chosen = np.inf, -1
    for i in range(i0, i1):
        for j in range(j0, j1):
            k = waypoint[i, j]
            if k >= 0:
                total = math.hypot(waypoints[k, 0] - x, waypoints[k, 1] - y) + remaining[k]
                if total < best:
                    best, chosen = total, k
    if chosen < 0:
        return 0.0, 0.0, np.inf
    return _ahead(chosen, waypoints, onward, x, y)


def is_reachable(paths: ShortestPaths, position: np.ndarray) -> bool:
    """Whether a path leads from position (2,) to the goal, or it is there already."""
    if np.hypot(*(paths.goal - position)) <= paths.tolerance:
        return True
    (ox, oy), (x, y) = paths.origin, position
    _, last, _, _ = _cells_near(paths.waypoint, float(ox), float(oy), paths.spacing, float(x), float(y))
    return bool(last > 0)
