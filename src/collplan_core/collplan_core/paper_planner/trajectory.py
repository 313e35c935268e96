"""Waypoints, duration and the cubic B-spline through them. Paper: III-A.

Four control points with clamped ends make one cubic, so that a constant basis matrix evaluates the B-spline.
"""

import math

import numpy as np

from collplan_core.jit import njit

LONGEST_HANDLE = 0.4  # of the chord: beyond it the cubic forms loops


@njit
def waypoints(start: np.ndarray, velocity: np.ndarray, end: np.ndarray, end_velocity: np.ndarray, duration: float,
              on_chord: bool) -> np.ndarray:  # fmt: skip
    """WP (4, 2): p, p + v_cur T/3, p_s - v_s T/3, p_s, handles at most 0.4 chord; or evenly on the chord."""
    points = np.empty((4, 2))
    points[0], points[3] = start, end
    if on_chord:
        points[1], points[2] = start + (end - start) / 3.0, start + (end - start) * 2.0 / 3.0
        return points
    limit = LONGEST_HANDLE * math.hypot(end[0] - start[0], end[1] - start[1])
    first, last = velocity * duration / 3.0, end_velocity * duration / 3.0
    points[1] = start + first * min(1.0, limit / max(math.hypot(first[0], first[1]), 1e-12))
    points[2] = end - last * min(1.0, limit / max(math.hypot(last[0], last[1]), 1e-12))
    return points


@njit
def polygon_length(points: np.ndarray) -> float:
    """Sum of |WP[i] - WP[i-1]| [m]."""
    total = 0.0
    for i in range(1, len(points)):
        total += math.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
    return total


@njit
def spline(points: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions (n, 2) and derivatives by share (n, 2) of the clamped cubic B-spline at shares (n,) of its duration."""
    n = len(share)
    position, derivative = np.empty((n, 2)), np.empty((n, 2))
    for i in range(n):
        t = share[i]
        s = 1.0 - t
        for a in range(2):
            w0, w1, w2, w3 = points[0, a], points[1, a], points[2, a], points[3, a]
            position[i, a] = s * s * s * w0 + 3 * s * s * t * w1 + 3 * s * t * t * w2 + t * t * t * w3
            derivative[i, a] = 3 * (s * s * (w1 - w0) + 2 * s * t * (w2 - w1) + t * t * (w3 - w2))
    return position, derivative


@njit
def stretched(points: np.ndarray, duration: float, max_speed: float, max_acceleration: float) -> float:
    """The duration, grown until peak speed and peak acceleration of the spline are within their limits [s]."""
    _, derivative = spline(points, np.linspace(0.0, 1.0, 129))
    fastest = 0.0
    for i in range(len(derivative)):
        fastest = max(fastest, math.hypot(derivative[i, 0], derivative[i, 1]))
    bend = 0.0
    for i in range(2):  # the second derivative is linear, its peak is at an end
        ax = points[i + 2, 0] - 2 * points[i + 1, 0] + points[i, 0]
        ay = points[i + 2, 1] - 2 * points[i + 1, 1] + points[i, 1]
        bend = max(bend, 6.0 * math.hypot(ax, ay))
    return max(duration, 1.0001 * fastest / max_speed, math.sqrt(bend / max_acceleration))


@njit
def make_trajectory(start: np.ndarray, velocity: np.ndarray, end: np.ndarray, end_velocity: np.ndarray,
                    max_speed: float, map_period: float, time_scale: float, max_acceleration: float, on_chord: bool,
                    as_printed: bool) -> tuple[np.ndarray, float]:  # fmt: skip
    """Waypoints and T = max(T_v, T_map), T_v = P_safe * length / v_max; they depend on each other: three passes.

    Unless as_printed, T then grows until the motors can follow.
    """
    duration = max(map_period, time_scale * math.hypot(end[0] - start[0], end[1] - start[1]) / max_speed)
    points = waypoints(start, velocity, end, end_velocity, duration, on_chord)
    for _ in range(3):
        duration = max(map_period, time_scale * polygon_length(points) / max_speed)
        points = waypoints(start, velocity, end, end_velocity, duration, on_chord)
    if not as_printed:
        duration = stretched(points, duration, max_speed, max_acceleration)
    return points, duration
