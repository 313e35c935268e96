"""Impacts found in poses alone: a kink in the path that the wheels cannot make.

The reflection ring is passive. An impact changes the velocity at once while the position stays continuous, so the poses
of the last moments are fitted with two parabolas that meet at the time of the impact:

    p(t) = p_0 + v_0 t + a_0 t^2 / 2   before,      p(t) = p_0 + (v_0 + c) t + a_1 t^2 / 2   after (t = 0 at the impact)

by least squares, with the accelerations a_0 and a_1 held near zero as the wheels' limit demands. The change of velocity
c is compared with its own standard deviation, for each pair of neighbouring poses between which the impact may lie.

The noise is that of mocap.position_noise, or what the fit leaves of the poses, where that is more. What no wall can do
is no impact: a wall turns back a robot that came towards it, at speeds that it can have. Steps of a position, another
body, noise that nobody told and a clock that changes look otherwise.

At 100 Hz and 2 mm of noise, driven hard (simulated): changes of 0.6 m/s and more are all found, half of them within
35 ms (0.6 m/s) and 25 ms (1 m/s); of 0.4 m/s two thirds, of 0.3 m/s one third, within 50 to 80 ms. With 0.2 mm of noise
0.3 m/s is found, half within 35 ms. The change reported is off by 0.1 to 0.2 m/s at 2 mm, by 0.05 m/s at 0.2 mm; the
time reported by 2 ms in the median and 7 ms in nine of ten, at 2 mm.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.impact import POSES, Impact, measured_impact
from collplan_core.jit import njit
from collplan_core.parameters import Mocap, Robot

IMPACT_SPAN = 3.6
"""Span of the poses that are fitted, in impact_windows."""
IMPACT_REACH = 1.6
"""Span back in time in which an impact is searched, in impact_windows."""
CERTAINTY = 5.8
"""Change of velocity from which an impact is certain, in standard deviations.

Two hours of driving at max_acceleration with 2 mm of noise gave no false impact; at 5.5 they gave one.
"""
SPEED_ALLOWANCE = 1.2
"""Largest speed that poses may show, as a multiple of the robot's largest."""
BELIEF = 6.0
"""Weight of mocap.position_noise beside the noise that poses show, in coordinates measured."""
LIKELIER = 1.0
"""A step of the position that leaves less than this share of what an impact leaves is the better explanation."""
UNCERTAIN = 0.25
"""Uncertainty of the velocities before and after an impact, as a share of the change."""
ACCELERATION_SHARE = 0.5
"""Standard deviation of an acceleration by axis, as a share of max_acceleration."""
SLACK = 1e-4
"""Tolerance on stamps, which are not evenly spaced to the last digit [s]."""
FEWEST_BEFORE = 2
"""Poses that a velocity before the impact needs."""
FEWEST_AFTER = 2
"""Poses waited for after an impact: one alone cannot separate its time from its strength."""
FINE = 8
"""Times tried between two poses once an impact is certain."""

_UNKNOWNS = 5


class ImpactLaw(NamedTuple):
    """Criteria by which poses show an impact."""

    window: float  # time within which a change of velocity counts as an impact [s]
    least_change: float  # smallest change of velocity that counts as one [m/s]
    position_deviation: float  # standard deviation of a measured position by axis [m]
    acceleration_deviation: float  # standard deviation of an acceleration by axis [m/s^2]
    most_speed: float  # largest speed of the robot [m/s]


def top_speed(robot: Robot) -> float:
    """Returns the largest speed that poses of a robot may show, without their noise [m/s]."""
    return SPEED_ALLOWANCE * robot.fastest


def impact_law(robot: Robot, mocap: Mocap, shown: float = 0.0) -> ImpactLaw:
    """The law for a robot, the motion capture that measures it, and the acceleration that it has shown [m/s^2]."""
    largest = max(robot.max_acceleration, shown)
    # accelerations that swing within the window are no parabola
    noise = math.hypot(mocap.position_noise, largest * mocap.impact_window**2 / 4)
    # what the wheels can make by swinging from one extreme to the other
    least = max(mocap.impact_speed, 2.0 * largest * mocap.impact_window)
    return ImpactLaw(mocap.impact_window, least, noise, ACCELERATION_SHARE * largest, top_speed(robot))


class FittedImpact(NamedTuple):
    """The least-squares fit with an impact at one tried time."""

    score: float  # change of velocity, in standard deviations; 0 where there is no impact
    first_after: int  # index of the first pose after the impact, at least FEWEST_BEFORE
    time: float  # time of the impact [s]
    x: float  # x, y: centre of the robot then [m]
    y: float
    before_x: float  # before_x, before_y: velocity before it [m/s]
    before_y: float
    change_x: float  # change_x, change_y: change of the velocity [m/s]
    change_y: float


NO_IMPACT = FittedImpact(0.0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def detected_impact(fit: FittedImpact, radius: float) -> Impact | None:
    """The impact that was fitted, of a robot with a radius [m]; None if there is none."""
    if fit.score == 0.0:
        return None
    center, before = np.array([fit.x, fit.y]), np.array([fit.before_x, fit.before_y])
    return measured_impact(fit.time, center, before, np.array([fit.change_x, fit.change_y]), radius, POSES)


class _Search(NamedTuple):
    """Times at which an impact is tried: `parts` of them before each pose first to last, none before `earliest` [s]."""

    first: int
    last: int
    parts: int
    earliest: float


@njit
def find_impact(times: np.ndarray, points: np.ndarray, law: ImpactLaw) -> FittedImpact:
    """The impact in these poses: times (n,) strictly rising [s], points (n, 2) [m] or more columns; else NO_IMPACT."""
    first = max(int(np.searchsorted(times, times[0] + law.window - SLACK)), FEWEST_BEFORE)
    last = len(times) - 1
    coarse = _Search(first, last, 1, times[-1] - IMPACT_REACH * law.window)
    coarse_fit = _likeliest_impact(times, points, coarse, law)
    if coarse_fit.score < CERTAINTY or len(times) - coarse_fit.first_after < FEWEST_AFTER:
        return NO_IMPACT
    near = coarse_fit.first_after
    fine = _Search(max(near - 1, first), min(near + 1, last), FINE, -math.inf)
    fine_fit = _likeliest_impact(times, points, fine, law)
    if math.hypot(fine_fit.change_x, fine_fit.change_y) < law.least_change:
        return NO_IMPACT
    return fine_fit if _is_made_by_a_wall(times, points, fine_fit, law) else NO_IMPACT


@njit
def _is_made_by_a_wall(times: np.ndarray, points: np.ndarray, fit: FittedImpact, law: ImpactLaw) -> bool:
    """Returns whether a wall can have made a change of velocity, and noise as large as what is left cannot."""
    solved = _fitted(times, points, fit.time, law, True)
    change = math.hypot(fit.change_x, fit.change_y)
    x, y = fit.change_x / change, fit.change_y / change
    before_x, before_y = fit.before_x, fit.before_y
    after_x, after_y = before_x + fit.change_x, before_y + fit.change_y
    doubt = UNCERTAIN * change
    if before_x * x + before_y * y > doubt or after_x * x + after_y * y < -doubt:
        return False
    fastest = max(math.hypot(before_x, before_y), math.hypot(after_x, after_y))
    if fastest > law.most_speed + doubt or change > 2.0 * law.most_speed:
        return False
    left = _left(times, points, fit.time, solved, True)
    for k in range(FEWEST_BEFORE, len(times)):
        time = 0.5 * (times[k - 1] + times[k])
        stepped = _fitted(times, points, time, law, False)
        if _left(times, points, time, stepped, False) < LIKELIER * left:
            return False
    # few poses alone do not say how noisy they are
    left += BELIEF * law.position_deviation**2
    noise = math.sqrt(left / (BELIEF + max(2 * len(times) - 2 * _UNKNOWNS, 0)))
    return fit.score * law.position_deviation >= CERTAINTY * noise


@njit
def _left(times: np.ndarray, points: np.ndarray, time: float, solved: np.ndarray, kinks: bool) -> float:
    """Sum of the squared distances of the poses from a fit [m^2]."""
    total = 0.0
    for k in range(len(times)):
        row = _row(times[k] - time, kinks)
        for axis in range(2):
            fitted = 0.0
            for i in range(_UNKNOWNS):
                fitted += row[i] * solved[i, _UNKNOWNS + axis]
            total += (points[k, axis] - fitted) ** 2
    return total


@njit
def _row(t: float, kinks: bool) -> tuple[float, float, float, float, float]:
    """Factors of p_0, v_0, c, a_0, a_1 in the position, a time after the impact [s]; of a step [m] instead of c."""
    before, after = min(t, 0.0), max(t, 0.0)
    step = 1.0 if t > 0.0 else 0.0
    return 1.0, t, after if kinks else step, 0.5 * before * before, 0.5 * after * after


@njit
def _likeliest_impact(times: np.ndarray, points: np.ndarray, search: _Search, law: ImpactLaw) -> FittedImpact:
    """The time with the largest score; NO_IMPACT where none was tried."""
    best = NO_IMPACT
    for after in range(search.last, search.first - 1, -1):
        for part in range(search.parts):
            time = times[after] - (part + 0.5) / search.parts * (times[after] - times[after - 1])
            if time < search.earliest:
                return best
            solved = _fitted(times, points, time, law, True)
            change_x, change_y = solved[2, 5], solved[2, 6]
            score = math.sqrt((change_x**2 + change_y**2) / solved[2, 7]) / law.position_deviation
            if score > best.score:
                before_x, before_y = solved[1, 5], solved[1, 6]
                x, y = solved[0, 5], solved[0, 6]
                best = FittedImpact(score, after, time, x, y, before_x, before_y, change_x, change_y)
    return best


@njit
def _fitted(times: np.ndarray, points: np.ndarray, time: float, law: ImpactLaw, kinks: bool) -> np.ndarray:
    """The solved normal equations of an impact at a time [s], or of a step of the position where it is no kink."""
    return _solved(_normal_equations(times, points, time, law.position_deviation / law.acceleration_deviation, kinks))


@njit
def _normal_equations(
    times: np.ndarray, points: np.ndarray, impact_time: float, stiffness: float, kinks: bool
) -> np.ndarray:
    """(5, 8): unknowns p_0, v_0, c, a_0, a_1; right-hand sides x, y and the unit vector of c, for its variance."""
    m = np.zeros((_UNKNOWNS, _UNKNOWNS + 3))
    for k in range(len(times)):
        row = (*_row(times[k] - impact_time, kinks), points[k, 0], points[k, 1])
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
def _solved(m: np.ndarray) -> np.ndarray:
    """`m` with the solutions in its last columns, by Gauss-Jordan; positive definite, so without pivoting."""
    # np.linalg.solve takes half as long again and rounds otherwise, so that runs would no longer repeat
    for i in range(_UNKNOWNS):
        for k in range(_UNKNOWNS + 2, i - 1, -1):
            m[i, k] /= m[i, i]
        for j in range(_UNKNOWNS):
            if j != i:
                for k in range(_UNKNOWNS + 2, i - 1, -1):
                    m[j, k] -= m[j, i] * m[i, k]
    return m
