"""Waypoints WP, duration T and the cubic B-spline Spl through them. Paper: III-A, eq. (4) and (5).

Four control points with clamped ends make one cubic, so that a constant basis matrix evaluates the B-spline.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Settings
from collplan_core.state import State
from collplan_core.velocity_bounds import VelocityBounds, share_along, velocity_bounds

MAP_PERIOD = 0.2
"""T_map where planner.map_period is 0 [s]."""
PEAK = 2.0
"""Peak acceleration of a spline over the robot's max_acceleration."""
N_SAMPLES = 64
"""Samples of a published plan."""
LONGEST_HANDLE = 0.4  # of the chord: beyond it the cubic forms loops
TOLERANCE = 1e-3  # share of T by which the T of the handles may be shorter


class TimeLaw(NamedTuple):
    """Parameters that the duration T of a trajectory depends on."""

    bounds: VelocityBounds  # v_max by direction
    map_period: float  # T_map [s]
    time_scale: float  # P_safe
    peak_speed: float
    """Limit of the spline [m/s]; inf as printed. The speed is multiplied by the share of its direction, as lengths
    below."""
    peak_acceleration: float  # limit of the spline [m/s^2]; inf as printed


def limited_time_law(settings: Settings, yaw: float) -> TimeLaw:
    """T grows until the motors can follow the spline; the robot holds its yaw [rad]."""
    robot, planner = settings.robot, settings.planner
    peak = PEAK * robot.max_acceleration
    map_period = planner.map_period or MAP_PERIOD
    return TimeLaw(velocity_bounds(robot, yaw), map_period, planner.time_scale, robot.max_speed, peak)


def printed_time_law(settings: Settings, yaw: float) -> TimeLaw:
    """T as printed, whatever it asks of the motors. Paper: eq. (4)."""
    return limited_time_law(settings, yaw)._replace(peak_speed=math.inf, peak_acceleration=math.inf)


TIME_LAWS = {"acceleration_limited": limited_time_law, "printed": printed_time_law}
"""The limits on T by planner.time_law."""


@njit
def traverse_time(length: float, law: TimeLaw) -> float:
    """T_v = P_safe length / v_max [s] of the polygon through the waypoints. Paper: eq. (5)."""
    return law.time_scale * length / law.bounds.max_speed


@njit
def printed_duration(length: float, law: TimeLaw) -> float:
    """T = max(T_v, T_map) [s]. Paper: eq. (4)."""
    return max(law.map_period, traverse_time(length, law))


@njit
def _handle(velocity: np.ndarray, duration: float, longest: float) -> tuple[float, float]:
    """The way v T/3 at an end's velocity (2,), cut to at most so long [m]."""
    x, y = velocity[0] * duration / 3.0, velocity[1] * duration / 3.0
    share = min(1.0, longest / max(math.hypot(x, y), 1e-12))
    return x * share, y * share


@njit
def clamped_waypoints(
    start: np.ndarray, velocity: np.ndarray, end: np.ndarray, end_velocity: np.ndarray, duration: float
) -> np.ndarray:
    """WP (4, 2): p, p + v_cur T/3, p_s - v_s T/3, p_s, handles at most LONGEST_HANDLE of the chord."""
    points = np.empty((4, 2))
    points[0], points[3] = start, end
    longest = LONGEST_HANDLE * math.hypot(end[0] - start[0], end[1] - start[1])
    x, y = _handle(velocity, duration, longest)
    points[1, 0], points[1, 1] = start[0] + x, start[1] + y
    x, y = _handle(end_velocity, duration, longest)
    points[2, 0], points[2, 1] = end[0] - x, end[1] - y
    return points


@njit
def chord_waypoints(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """WP (4, 2) evenly on the chord from p to p_s."""
    points = np.empty((4, 2))
    points[0], points[3] = start, end
    points[1], points[2] = start + (end - start) / 3.0, start + (end - start) * 2.0 / 3.0
    return points


@njit
def _length(x: float, y: float, bounds: VelocityBounds) -> float:
    """Length of (x, y), less where its direction is faster than v_max [m]."""
    return math.hypot(x, y) * share_along(bounds, x, y)


@njit
def polygon_length(points: np.ndarray, bounds: VelocityBounds) -> float:
    """Sum of |WP[i] - WP[i-1]| [m]."""
    total = 0.0
    for i in range(1, len(points)):
        total += _length(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1], bounds)
    return total


@njit
def _derivative(points: np.ndarray, t: float, a: int) -> float:
    """Derivative of coordinate a of the spline with respect to the spline parameter t, in [0, 1] [m]."""
    s = 1.0 - t
    p0, p1, p2, p3 = points[0, a], points[1, a], points[2, a], points[3, a]
    return 3 * (s * s * (p1 - p0) + 2 * s * t * (p2 - p1) + t * t * (p3 - p2))


@njit
def spline(points: np.ndarray, parameter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The clamped cubic B-spline through waypoints (4, 2): positions (n, 2) [m] and derivatives (n, 2) [m].

    The derivatives are with respect to the spline parameter (n,), the share of the duration that has passed, in [0, 1].
    """
    n = len(parameter)
    position, derivative = np.empty((n, 2)), np.empty((n, 2))
    for i in range(n):
        t = parameter[i]
        s = 1.0 - t
        for a in range(2):
            p0, p1, p2, p3 = points[0, a], points[1, a], points[2, a], points[3, a]
            position[i, a] = s * s * s * p0 + 3 * s * s * t * p1 + 3 * s * t * t * p2 + t * t * t * p3
            derivative[i, a] = _derivative(points, t, a)
    return position, derivative


@njit
def limited_duration(points: np.ndarray, duration: float, law: TimeLaw) -> float:
    """The duration [s], grown until peak speed and peak acceleration of the spline are within their limits."""
    fastest = 0.0
    for i in range(129):
        x, y = _derivative(points, i / 128.0, 0), _derivative(points, i / 128.0, 1)
        fastest = max(fastest, _length(x, y, law.bounds))
    bend = 0.0
    for i in range(2):  # the second derivative is linear, its peak is at an end
        ax = points[i + 2, 0] - 2 * points[i + 1, 0] + points[i, 0]
        ay = points[i + 2, 1] - 2 * points[i + 1, 1] + points[i, 1]
        bend = max(bend, 6.0 * math.hypot(ax, ay))
    return max(duration, 1.0001 * fastest / law.peak_speed, math.sqrt(bend / law.peak_acceleration))


@njit
def clamped_trajectory(
    start: np.ndarray, velocity: np.ndarray, end: np.ndarray, end_velocity: np.ndarray, law: TimeLaw
) -> tuple[np.ndarray, float]:
    """Clamped waypoints (4, 2) and their duration T [s]. Paper: III-A, eq. (4) and (5).

    They lead from p_cur [m] at v_cur [m/s] to p_s [m] at v_s [m/s], each (2,). The handles are as long as T says, and T
    is as long as the waypoints are: a fixed point. T is exactly that of the waypoints returned; their handles are those
    of a T shorter by at most TOLERANCE.
    """
    of_handles = printed_duration(_length(end[0] - start[0], end[1] - start[1], law.bounds), law)
    points = clamped_waypoints(start, velocity, end, end_velocity, of_handles)
    duration = printed_duration(polygon_length(points, law.bounds), law)
    # from the chord on T only grows, to 1 + 4 sqrt 2 LONGEST_HANDLE times that of the chord at most: the loop ends
    while duration > (1.0 + TOLERANCE) * of_handles:
        of_handles = duration
        points = clamped_waypoints(start, velocity, end, end_velocity, of_handles)
        duration = printed_duration(polygon_length(points, law.bounds), law)
    return points, limited_duration(points, duration, law)


@njit
def chord_trajectory(
    start: np.ndarray, velocity: np.ndarray, end: np.ndarray, end_velocity: np.ndarray, law: TimeLaw
) -> tuple[np.ndarray, float]:
    """Waypoints (4, 2) on the chord from start (2,) to end (2,) [m], and duration T [s]; velocities play no part."""
    points = chord_waypoints(start, end)
    return points, limited_duration(points, printed_duration(polygon_length(points, law.bounds), law), law)


WAYPOINTS = {"clamped": clamped_trajectory, "chord": chord_trajectory}
"""WP and T by planner.waypoints."""


def make_trajectory(
    state: State, aim: np.ndarray, aim_velocity: np.ndarray, settings: Settings
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The reference from p_cur to p_s: times from 0 (n,) [s], positions (n, 2) [m], velocities (n, 2) [m/s].

    Paper: III-A.
    """
    planner = settings.planner
    law = TIME_LAWS[planner.time_law](settings, state.yaw)
    points, duration = WAYPOINTS[planner.waypoints](state.position, state.velocity, aim, aim_velocity, law)
    parameter = np.arange(N_SAMPLES) / (N_SAMPLES - 1)
    positions, derivative = spline(points, parameter)
    return parameter * duration, positions, derivative / duration
