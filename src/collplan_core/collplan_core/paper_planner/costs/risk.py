"""J_risk: time to collision with predicted boundaries, width of the opening, boundaries in the way. Paper: Alg. 2."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import boundary_at, inside, sector
from collplan_core.local_map.sight import sight_angle


@njit
def impact_distance(px: float, py: float, ux: float, uy: float, predicted: np.ndarray) -> tuple[float, int]:
    """d_p and the predicted half line that the ray from p along the unit vector u meets first; (inf, -1) for none."""
    best, which = math.inf, -1
    for k in range(len(predicted)):
        ox, oy, ex, ey = predicted[k]
        cross = ux * ey - uy * ex
        if abs(cross) < 1e-12:
            continue
        along_ray = ((ox - px) * ey - (oy - py) * ex) / cross
        along_line = ((ox - px) * uy - (oy - py) * ux) / cross
        if along_ray > 1e-9 and along_line >= 0.0 and along_ray < best:
            best, which = along_ray, k
    return best, which


@njit
def distance_to_predicted(px: float, py: float, predicted: np.ndarray) -> float:
    """Smallest distance from p to a predicted half line; inf where there is none."""
    best = math.inf
    for k in range(len(predicted)):
        ox, oy, ex, ey = predicted[k]
        along = max(0.0, (px - ox) * ex + (py - oy) * ey)
        best = min(best, math.hypot(px - ox - along * ex, py - oy - along * ey))
    return best


@njit
def collision_rate(px: float, py: float, vx: float, vy: float, predicted: np.ndarray, speed_floor: float,
                   time_floor: float) -> tuple[float, float, int]:  # fmt: skip
    """1 / t_c of a candidate, d_p, and the half line it meets (-1: none, then the rate is 0; at rest always -1)."""
    speed = math.hypot(vx, vy)
    if speed > 0.0:
        distance, which = impact_distance(px, py, vx / speed, vy / speed, predicted)
    else:
        speed, which = speed_floor, -1
        distance = distance_to_predicted(px, py, predicted)
    if distance == math.inf:
        return 0.0, math.inf, -1
    return 1.0 / max(distance / speed, time_floor), distance, which


@njit
def gap_risk(reach: np.ndarray, x: float, y: float, from_robot: float, clockwise: bool, counter_clockwise: bool,
             far: float, gap_weight: float, widest: float, as_printed: bool) -> float:  # fmt: skip
    """J_risk,g = -f_theta theta_sight, times the distance from p_cur (the opening's width) unless as printed.

    x, y: the candidate relative to the centre of F [m]; from_robot: |p_s - p_cur| [m].
    """
    angle = sight_angle(reach, x, y, clockwise, counter_clockwise, far)
    return -gap_weight * (angle if as_printed else min(angle * from_robot, widest))


@njit
def crosses_boundary(ends: np.ndarray, surface: np.ndarray, shadow: np.ndarray, px: float, py: float,
                     vx: float, vy: float, sx: float, sy: float, max_speed: float) -> bool:  # fmt: skip
    """Whether the approach leaves F through an observed boundary.

    The approach is the cubic from p with velocity v to p_s, reached straight at v_max; handles at most 0.4 chord.
    All relative to the centre of F.
    """
    cx, cy = sx - px, sy - py
    chord = math.hypot(cx, cy)
    if chord < 1e-9:
        return False
    handle = chord / max_speed / 3.0
    long = math.hypot(vx, vy) * handle
    handle = handle if long <= 0.4 * chord else handle * 0.4 * chord / long
    ax, ay = px + vx * handle, py + vy * handle
    bx, by = sx - cx / 3.0, sy - cy / 3.0
    for i in range(1, 12):
        t = i / 12.0
        w0, w1, w2, w3 = (1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t * t * (1 - t), t**3
        x, y = w0 * px + w1 * ax + w2 * bx + w3 * sx, w0 * py + w1 * ay + w2 * by + w3 * sy
        if not inside(ends, x, y):
            return boundary_at(surface, shadow, sector(x, y, len(ends))) >= 0
    return False
