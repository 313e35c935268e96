"""The time to go from a state, looked up in the shortest paths."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import Grid
from collplan_core.time_to_goal_planner.shortest_paths.record import PathLookup, ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.waypoints import NEAREST, turn
from collplan_core.velocity_bounds import VelocityBounds, fastest_along, share_along

MAYBE_TURNED, NOT_TURNED = 0.2, 0.4
"""Distances of a waypoint up to which its turn may have been made already, and from which it has not [m]."""
RINGS = 3
"""Inside a known obstacle a path begins at the nearest free cells, at most so many cells away."""


class _Waypoint(NamedTuple):
    """A waypoint's row of ShortestPaths, and whether it is the goal: there the path does not go on."""

    x: float
    y: float
    onward_x: float
    onward_y: float
    remaining: float
    turning: float
    is_goal: bool


@njit
def _waypoint(
    waypoints: np.ndarray, onward: np.ndarray, remaining: np.ndarray, turning: np.ndarray, k: int
) -> _Waypoint:
    return _Waypoint(waypoints[k, 0], waypoints[k, 1], onward[k, 0], onward[k, 1], remaining[k], turning[k], k == 0)


@njit
def _ahead(point: _Waypoint, x: float, y: float) -> tuple[float, float, float]:
    """Unit direction from (x, y) along the path by a waypoint, and the distance to that [m]."""
    # Toward a point NEAREST ahead on the path: so close to a waypoint the direction to it means nothing.
    dx, dy = point.x - x, point.y - y
    distance = math.hypot(dx, dy)
    beyond = max(NEAREST - distance, 0.0)
    dx, dy = dx + beyond * point.onward_x, dy + beyond * point.onward_y
    far = math.hypot(dx, dy)
    if far < 1e-9:
        return point.onward_x, point.onward_y, distance
    return dx / far, dy / far, distance


@njit
def _swing(ux: float, uy: float, bounds: VelocityBounds, max_acceleration: float, vx: float, vy: float) -> float:
    """Time that it costs not to move at full speed along u already [s]."""
    speed = fastest_along(bounds, ux, uy)
    return ((speed * ux - vx) ** 2 + (speed * uy - vy) ** 2) / (2.0 * max_acceleration * speed)


@njit
def _time_by(
    point: _Waypoint, bounds: VelocityBounds, max_acceleration: float, x: float, y: float, vx: float, vy: float
) -> float:
    """Time to go from (x, y) at (vx, vy) by a waypoint first [s]."""
    # The velocity has to become that toward the waypoint, which then turns there. Or it has that turn behind it and has
    # to become the one onward, if that is faster: wholly up to MAYBE_TURNED from the waypoint, by less and less
    # up to NOT_TURNED. Beyond the waypoint it counts with max_speed, of which a box may allow more.
    ux, uy, distance = _ahead(point, x, y)
    time = (distance * share_along(bounds, ux, uy) + point.remaining) / bounds.max_speed
    before = _swing(ux, uy, bounds, max_acceleration, vx, vy)
    if point.is_goal:
        return time + before
    wx, wy = point.onward_x, point.onward_y
    cost = 0.5 * bounds.max_speed / max_acceleration
    before += cost * turn(ux * wx + uy * wy)
    behind = _swing(wx, wy, bounds, max_acceleration, vx, vy)
    share = min(max((NOT_TURNED - distance) / (NOT_TURNED - MAYBE_TURNED), 0.0), 1.0)
    return time + cost * point.turning + before - share * max(before - behind, 0.0)


@njit
def _before(along: float, count: int) -> int:
    """Cell before a place on an axis [cells], such that it and the one after it exist."""
    return min(max(int(math.floor(along)), 0), count - 2)


@njit
def _cells_near(waypoint: np.ndarray, cells: Grid, x: float, y: float) -> tuple[int, int, int, int]:
    """Cells [i0, i1) x [j0, j1): the four around (x, y) or, where these have no path, so many rings more; or none."""
    mx, my = waypoint.shape
    i, j = _before((x - cells.x) / cells.spacing, mx), _before((y - cells.y) / cells.spacing, my)
    for ring in range(RINGS + 1):
        i0, i1, j0, j1 = max(i - ring, 0), min(i + 2 + ring, mx), max(j - ring, 0), min(j + 2 + ring, my)
        for a in range(i0, i1):
            for b in range(j0, j1):
                if waypoint[a, b] >= 0:
                    return i0, i1, j0, j1
    return 0, 0, 0, 0


@njit
def time_to_go(
    paths: PathLookup, bounds: VelocityBounds, max_acceleration: float, x: float, y: float, vx: float, vy: float
) -> float:
    """Time from (x, y) at (vx, vy) to the goal, inf where no path leads there, 0 within its tolerance [s].

    Of the waypoints that the four cells around lead to, the one that is best counts: there is no step where one cell
    ends.
    """
    if (x - paths.goal_x) ** 2 + (y - paths.goal_y) ** 2 <= paths.tolerance * paths.tolerance:
        return 0.0
    # arrays one by one: taking them out of the tuple at every cell counts their references
    waypoint, waypoints, onward = paths.waypoint, paths.waypoints, paths.onward
    remaining, turning = paths.remaining, paths.turning
    i0, i1, j0, j1 = _cells_near(waypoint, paths.cells, x, y)
    best, last = np.inf, -1
    for i in range(i0, i1):
        for j in range(j0, j1):
            k = waypoint[i, j]
            if k >= 0 and k != last:
                last = k
                point = _waypoint(waypoints, onward, remaining, turning, k)
                best = min(best, _time_by(point, bounds, max_acceleration, x, y, vx, vy))
    return best


@njit
def waypoint_near(paths: PathLookup, x: float, y: float) -> int:
    """Number of the waypoint that the shortest path from (x, y) leads to first, -1 where none leads to the goal."""
    waypoint, waypoints, remaining = paths.waypoint, paths.waypoints, paths.remaining
    i0, i1, j0, j1 = _cells_near(waypoint, paths.cells, x, y)
    best, chosen = np.inf, -1
    for i in range(i0, i1):
        for j in range(j0, j1):
            k = waypoint[i, j]
            if k >= 0:
                total = math.hypot(waypoints[k, 0] - x, waypoints[k, 1] - y) + remaining[k]
                if total < best:
                    best, chosen = total, int(k)
    return chosen


@njit
def path_direction(paths: PathLookup, x: float, y: float) -> tuple[float, float, float]:
    """Unit direction from (x, y) along the shortest path and the distance to its first waypoint [m].

    (0, 0) and inf where no path leads to the goal.
    """
    k = waypoint_near(paths, x, y)
    if k < 0:
        return 0.0, 0.0, np.inf
    return _ahead(_waypoint(paths.waypoints, paths.onward, paths.remaining, paths.turning, k), x, y)


def is_reachable(paths: ShortestPaths, position: np.ndarray) -> bool:
    """Returns whether a path leads to the goal from a cell beside position (2,) [m], or the goal is reached already."""
    if np.hypot(*(paths.goal - position)) <= paths.tolerance:
        return True
    rows, columns = paths.waypoint.shape
    x, y = (position - paths.origin) / paths.spacing
    i, j = _before(x, rows), _before(y, columns)
    return bool((paths.waypoint[i : i + 2, j : j + 2] >= 0).any())
