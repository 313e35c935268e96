"""Hits found in poses alone: a kink in the path that the wheels cannot make.

The reflection ring is passive. A hit changes the velocity at once while the position stays continuous, so the poses of
the last moments are fitted with two parabolas that meet at the time of the hit:

    p(t) = p_0 + v_0 t + a_0 t^2 / 2   before,      p(t) = p_0 + (v_0 + c) t + a_1 t^2 / 2   after (t = 0 at the hit)

by least squares, with the accelerations a_0 and a_1 held near zero as the wheels' limit demands. The change of velocity
c is compared with its own standard deviation, for each pair of neighbouring poses between which the hit may lie.

At 100 Hz and 2 mm of noise, driven hard (simulated): changes of 0.6 m/s and more are all found, half of them within
35 ms (0.6 m/s) and 25 ms (1 m/s); of 0.4 m/s two thirds, of 0.3 m/s one third, within 50 to 80 ms. With 0.2 mm of noise
0.3 m/s is found, half within 35 ms. The change reported is off by 0.1 to 0.2 m/s at 2 mm, by 0.05 m/s at 0.2 mm.
"""

import math
from dataclasses import dataclass

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Mocap, Robot

IMPACT_SPAN = 3.6
"""Poses of so many impact_windows are fitted."""
IMPACT_REACH = 1.6
"""A hit is looked for so many impact_windows back."""
CERTAINTY = 5.8
"""Standard deviations; two hours of driving at max_acceleration, 2 mm of noise, gave no false hit; at 5.5, one."""
ACCELERATION_SHARE = 0.5
"""Standard deviation of an acceleration by axis, in max_acceleration."""
SLACK = 1e-4
"""Stamps are not evenly spaced to the last digit [s]."""
FEWEST_BEFORE = 2
"""Poses that a velocity before the hit needs."""
FEWEST_AFTER = 2
"""Poses waited for after a hit: from one alone its time cannot be told from its strength."""
FINE = 8
"""Times tried between two poses once a hit is certain."""

_UNKNOWNS = 5


@dataclass(frozen=True, eq=False)
class DetectedImpact:
    """A hit.

    Attributes:
        first_after: index of the first pose after it.
        time: when [s].
        point: (2,) where it happened [m].
        change: (2,) of velocity [m/s].
    """

    first_after: int
    time: float
    point: np.ndarray
    change: np.ndarray


def find_impact(times: np.ndarray, points: np.ndarray, robot: Robot, mocap: Mocap) -> DetectedImpact | None:
    """The hit in these poses: times (n,) strictly rising [s], points (n, 2) [m]; None if there is none."""
    first = max(int(np.searchsorted(times, times[0] + mocap.impact_window - SLACK)), FEWEST_BEFORE)
    last = len(times) - 1
    earliest = times[-1] - IMPACT_REACH * mocap.impact_window
    deviation = ACCELERATION_SHARE * robot.max_acceleration
    # accelerations that swing within the window are no parabola
    noise = math.hypot(mocap.position_noise, robot.max_acceleration * mocap.impact_window**2 / 4)
    score, after = _likeliest_impact(times, points, first, last, 1, earliest, noise, deviation)[:2]
    if score < CERTAINTY or len(times) - after < FEWEST_AFTER:
        return None
    near = (max(after - 1, first), min(after + 1, last))
    _, after, time, x, y, *change = _likeliest_impact(times, points, *near, FINE, -math.inf, noise, deviation)
    # what the wheels can make by swinging from one extreme to the other
    least = max(mocap.impact_speed, 2.0 * robot.max_acceleration * mocap.impact_window)
    if math.hypot(*change) < least:
        return None
    return DetectedImpact(int(after), float(time), np.array([x, y]), np.array(change))


@njit
def _likeliest_impact(times, points, first, last, parts, earliest, noise, deviation):  # type: ignore[no-untyped-def]
    """Score, first pose after, time, point, change of velocity: tries `parts` times before each pose first to last."""
    best = (0.0, first, 0.0, 0.0, 0.0, 0.0, 0.0)
    for after in range(last, first - 1, -1):
        for part in range(parts):
            time = times[after] - (part + 0.5) / parts * (times[after] - times[after - 1])
            if time < earliest:
                return best
            solved = _solved(_normal_equations(times, points, time, noise / deviation))
            x, y, change_x, change_y = solved[0, 5], solved[0, 6], solved[2, 5], solved[2, 6]
            score = math.sqrt((change_x**2 + change_y**2) / solved[2, 7]) / noise
            if score > best[0]:
                best = (score, after, time, x, y, change_x, change_y)
    return best


@njit
def _normal_equations(times, points, kink, stiffness):  # type: ignore[no-untyped-def]
    """Unknowns p_0, v_0, c, a_0, a_1; right-hand sides x, y and the unit vector of c, for its variance."""
    m = np.zeros((_UNKNOWNS, _UNKNOWNS + 3))
    row = np.zeros(_UNKNOWNS + 2)
    for k in range(len(times)):
        t = times[k] - kink
        row[0], row[1], row[2] = 1.0, t, max(t, 0.0)
        row[3], row[4] = 0.5 * min(t, 0.0) ** 2, 0.5 * max(t, 0.0) ** 2
        row[5], row[6] = points[k, 0], points[k, 1]
        for i in range(_UNKNOWNS):
            for j in range(i, _UNKNOWNS + 2):
                m[i, j] += row[i] * row[j]
    m[3, 3] += stiffness**2
    m[4, 4] += stiffness**2
    m[2, _UNKNOWNS + 2] = 1.0
    for i in range(_UNKNOWNS):
        for j in range(i):
            m[i, j] = m[j, i]
    return m


@njit
def _solved(m):  # type: ignore[no-untyped-def]
    """Gauss-Jordan without pivoting: the matrix is symmetric and positive definite."""
    for i in range(_UNKNOWNS):
        for k in range(_UNKNOWNS + 2, i - 1, -1):
            m[i, k] /= m[i, i]
        for j in range(_UNKNOWNS):
            if j != i:
                for k in range(_UNKNOWNS + 2, i - 1, -1):
                    m[j, k] -= m[j, i] * m[i, k]
    return m
