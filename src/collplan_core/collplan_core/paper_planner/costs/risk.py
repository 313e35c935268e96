"""J_risk: time to collision with predicted boundaries, width of the opening, boundaries in the way. Paper: Alg. 2."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import boundary_at, inside, sector
from collplan_core.local_map.sight import sight_angle
from collplan_core.paper_planner.costs.model import CostModel
from collplan_core.paper_planner.costs.total import normalize
from collplan_core.paper_planner.trajectory import LONGEST_HANDLE
from collplan_core.velocity_bounds import VelocityBounds, fastest_along


@njit
def contact_distance(px: float, py: float, ux: float, uy: float, predicted: np.ndarray) -> tuple[float, int]:
    """d_p [m] and the index of the half line that the ray from p along the unit vector u meets first; or (inf, -1)."""
    best, line = math.inf, -1
    for k in range(len(predicted)):
        ox, oy, ex, ey = predicted[k]
        cross = ux * ey - uy * ex
        if abs(cross) < 1e-12:
            continue
        along_ray = ((ox - px) * ey - (oy - py) * ex) / cross
        along_line = ((ox - px) * uy - (oy - py) * ux) / cross
        if along_ray > 1e-9 and along_line >= 0.0 and along_ray < best:
            best, line = along_ray, k
    return best, line


@njit
def distance_to_predicted(px: float, py: float, predicted: np.ndarray) -> float:
    """Smallest distance from p to a predicted half line [m]; inf where there is none."""
    best = math.inf
    for k in range(len(predicted)):
        ox, oy, ex, ey = predicted[k]
        along = max(0.0, (px - ox) * ex + (py - oy) * ey)
        best = min(best, math.hypot(px - ox - along * ex, py - oy - along * ey))
    return best


@njit
def collision_rate(
    px: float, py: float, vx: float, vy: float, predicted: np.ndarray, model: CostModel
) -> tuple[float, float, int]:
    """1 / t_c [1/s] with t_c = d_p / v_c (Alg. 2), d_p [m], and the index of the half line met.

    Moving: d_p along v_s, v_c = |v_s| (Proj of Alg. 2: s_p lies on the ray of v_s). At rest: d_p to the nearest half
    line, v_c = delta v, index -1. Nothing met: rate 0, d_p inf, index -1. `p` is p_s [m], `v` is v_s [m/s], and
    `predicted` (e, 4) is set E; p_s and E are relative to the centre of F.
    """
    speed = math.hypot(vx, vy)
    if speed > 0.0:
        distance, line = contact_distance(px, py, vx / speed, vy / speed, predicted)
        closing_speed = speed
    else:
        distance, line = distance_to_predicted(px, py, predicted), -1
        closing_speed = model.speed_floor
    if distance == math.inf:
        return 0.0, math.inf, -1
    return 1.0 / max(distance / closing_speed, model.time_floor), distance, line


@njit
def collision_risks(
    points: np.ndarray, velocities: np.ndarray, predicted: np.ndarray, model: CostModel
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """J_risk,h (c,) of each candidate: 1 / t_c, normalised; d_p (c,) [m], and the half line met (c,). Paper: Alg. 2.

    The half line is an index, -1 for none. Points and velocities (c, 2) are p_s [m] and v_s [m/s], `predicted` (e, 4)
    is set E; p_s and E are relative to the centre of F.
    """
    n = len(points)
    rate, distance, line = np.empty(n), np.empty(n), np.empty(n, np.int64)
    for i in range(n):
        rate[i], distance[i], line[i] = collision_rate(
            points[i, 0], points[i, 1], velocities[i, 0], velocities[i, 1], predicted, model
        )
    return normalize(rate), distance, line


@njit
def gap_risks(
    reach: np.ndarray,
    positions: np.ndarray,
    open_side: np.ndarray,
    current: np.ndarray,
    sight_distance: float,
    gap_weight: float,
    widest: float,
    printed: bool,
) -> np.ndarray:
    """J_risk,g = -f_theta theta_sight |p_s - p_cur| of each position (p,): the opening's width there. Paper: Alg. 2.

    Args:
        reach: (n,) free distance in direction 2 pi k / n from the centre of F [m].
        positions, current: (p, 2) p_s and (2,) p_cur, relative to the centre of F [m].
        open_side: (p, 2) the open sides of each one's frontier.
        sight_distance: distance over which a direction must be free to count as sight [m].
        gap_weight: f_theta; widest: wider openings count as this wide [m].
        printed: as Alg. 2, line 11, is printed, the angle alone counts: -f_theta theta_sight.
    """
    risk = np.empty(len(positions))
    for i in range(len(positions)):
        x, y = positions[i]
        angle = sight_angle(reach, x, y, open_side[i, 0], open_side[i, 1], sight_distance)
        from_robot = np.hypot(x - current[0], y - current[1])
        risk[i] = -gap_weight * (angle if printed else min(angle * from_robot, widest))
    return risk


@njit
def _crosses_boundary(
    border: np.ndarray,
    surface: np.ndarray,
    shadow: np.ndarray,
    current: np.ndarray,
    velocity: np.ndarray,
    sx: float,
    sy: float,
    bounds: VelocityBounds,
) -> bool:
    """Returns whether the cubic from p_cur to p_s, reached straight at v_max, leaves F through a boundary."""
    px, py = current
    cx, cy = sx - px, sy - py
    chord = math.hypot(cx, cy)
    if chord < 1e-9:
        return False
    handle_time = chord / fastest_along(bounds, cx, cy) / 3.0
    longest = LONGEST_HANDLE * chord
    handle_length = math.hypot(velocity[0], velocity[1]) * handle_time
    if handle_length > longest:
        handle_time = handle_time * LONGEST_HANDLE * chord / handle_length
    ax, ay = px + velocity[0] * handle_time, py + velocity[1] * handle_time
    bx, by = sx - cx / 3.0, sy - cy / 3.0
    for i in range(1, 12):
        t = i / 12.0
        w0, w1, w2, w3 = (1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3
        x, y = w0 * px + w1 * ax + w2 * bx + w3 * sx, w0 * py + w1 * ay + w2 * by + w3 * sy
        if not inside(border, x, y):
            return boundary_at(surface, shadow, sector(x, y, len(border))) >= 0
    return False


@njit
def crossings(
    border: np.ndarray,
    surface: np.ndarray,
    shadow: np.ndarray,
    positions: np.ndarray,
    current: np.ndarray,
    velocity: np.ndarray,
    bounds: VelocityBounds,
) -> np.ndarray:
    """1 for each position (p,) whose approach leaves F through an observed boundary, else 0.

    Border points (n, 2) of F, positions (p, 2), p_s, and `current` (2,), p_cur, are relative to the centre of F [m];
    surface and shadow (n,) are as in LocalMap. The velocity (2,) is v_cur [m/s], `bounds` are v_max by direction.
    """
    risk = np.zeros(len(positions))
    for i in range(len(positions)):
        risk[i] = _crosses_boundary(
            border, surface, shadow, current, velocity, positions[i, 0], positions[i, 1], bounds
        )
    return risk
