"""Velocities right before and right after an impact, from the poses around it.

No pose of the impact itself is used: a ring gives way for some milliseconds. The poses from 120 to 20 ms before and
from 20 to 120 ms after are fitted, by least squares, with one path that the wheels drive as commanded,

    dv/dt = (u - v) / lag, at most max_acceleration,

and whose velocity alone leaps, once, at an unknown time. At 100 Hz and 2 mm of noise either velocity is then known to
0.02 m/s by axis; a straight line instead of the commands' acceleration would be off by 0.1 m/s at 1.5 m/s^2.
"""

from dataclasses import dataclass
from math import hypot
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Robot
from collplan_core.velocity_law import VelocityLaw, velocity_after, velocity_law

NEAR, FAR = 0.02, 0.12
"""Shortest and longest time between an impact and the poses that are fitted, before and after it [s]."""
FEWEST_POSES = 5
"""Poses needed before an impact, and as many after it."""
UNEXPLAINED = 0.02
"""Standard deviation of a velocity by what wheels and floor do beyond the commands, by axis [m/s] (assumed)."""
LARGEST_MISFIT = 1.6
"""Largest misfit of the poses, in standard deviations; beyond it something else happened as well."""

WINDOWS = ((0.02, 0.06), (0.06, 0.12))
"""Times after an impact within which the velocity is looked at once more [s]."""
FEWEST_IN_WINDOW = 4
"""Poses that such a window needs."""

_MOST_ROUNDS = 4
_SCALES = np.array([0.01, 0.01, 0.1, 0.1, 0.1, 0.1, 0.01])
"""Typical sizes of the seven unknowns: first position and velocity, velocity after, time [m, m/s, m/s, s]."""


class UnusableImpact(ValueError):
    """Error of an impact whose velocities cannot be determined; the message gives the reason."""


@dataclass(frozen=True, eq=False)
class RecordedPath:
    """Measured poses, and the velocity commanded at each.

    Attributes:
        times: (n,) strictly rising [s].
        points: (n, 2) measured centres of the robot [m, world frame].
        wanted: (n, 2) velocity commanded from this pose to the next [m/s, world frame].
    """

    times: np.ndarray
    points: np.ndarray
    wanted: np.ndarray

    def between(self, begin: float, end: float) -> "RecordedPath":
        """The poses from `begin` to `end` [s], their times relative to the middle of the two."""
        first, last = np.searchsorted(self.times, (begin, end))
        part = slice(int(first), int(last))
        return RecordedPath(self.times[part] - 0.5 * (begin + end), self.points[part], self.wanted[part])


@dataclass(frozen=True, eq=False)
class ImpactFit:
    """A fitted impact, world frame.

    Attributes:
        time: time of the impact [s].
        position: (2,) centre of the robot then [m].
        before, after: (2,) velocity [m/s].
        driven: (2, 2) acceleration by the wheels right before and right after [m/s^2].
        covariance: (4, 4) covariance of (before, after) [m^2/s^2].
        beyond: (2, 2) velocity in each of WINDOWS less that of the path fitted, NaN with too few poses [m/s].
    """

    time: float
    position: np.ndarray
    before: np.ndarray
    after: np.ndarray
    driven: np.ndarray
    covariance: np.ndarray
    beyond: np.ndarray


def fit_impact(path: RecordedPath, time: float, robot: Robot, noise: float) -> ImpactFit:
    """The impact at about `time` [s]; `noise` is the standard deviation of a measured position by axis [m].

    Raises:
        UnusableImpact: too few poses around it, no single moment that explains them, or a path that misses them.
    """
    for _ in range(_MOST_ROUNDS):
        around = path.between(time - FAR, time + FAR)
        fitted = _fit_path(around, robot)
        time += float(fitted.unknowns[6])
        if abs(fitted.unknowns[6]) <= 0.5 * NEAR:
            return _checked(fitted, around, time, robot, noise)
    raise UnusableImpact("no single moment explains the poses around it")


class _FittedPath(NamedTuple):
    """The path nearest to the poses around an impact.

    Attributes:
        unknowns: (7,) position and velocity at the first pose, velocity after the impact, its time.
        jacobian: (m, 7) derivatives of the distances from the poses by the unknowns.
        misfit: root mean square distance from the poses by axis [m].
        off: (n, 2) distances of all poses from it, also of those that were not fitted [m].
    """

    unknowns: np.ndarray
    jacobian: np.ndarray
    misfit: float
    off: np.ndarray


def _checked(fitted: _FittedPath, around: RecordedPath, time: float, robot: Robot, noise: float) -> ImpactFit:
    """The impact at `time` [s] on a fitted path; raises UnusableImpact where the path misses the poses."""
    unknowns, jacobian, misfit, off = fitted
    deviation = hypot(noise, UNEXPLAINED * 0.5 * (FAR - NEAR))
    if misfit > LARGEST_MISFIT * deviation:
        raise UnusableImpact("the poses around it are not those of one impact")
    variances = max(deviation, misfit) ** 2 * np.linalg.pinv(jacobian.T @ jacobian)
    slopes = _slopes(unknowns, around, robot)
    before = _right_before(unknowns, around, robot)
    covariance = slopes @ variances @ slopes.T + UNEXPLAINED**2 * np.eye(4)
    since = around.times - unknowns[6]
    beyond = np.array([_extra_velocity(since, off, *window) for window in WINDOWS])
    wanted = around.wanted[np.searchsorted(around.times, unknowns[6], side="right") - 1]
    driven = np.array([_acceleration(velocity, wanted, robot) for velocity in (before[2:], unknowns[4:6])])
    return ImpactFit(time, before[:2], before[2:], unknowns[4:6], driven, covariance, beyond)


def _acceleration(velocity: np.ndarray, wanted: np.ndarray, robot: Robot) -> np.ndarray:
    """Acceleration (2,) by the wheels at a velocity (2,), with `wanted` (2,) commanded [m/s^2]."""
    moment = 1e-4
    soon = velocity_after(velocity_law(robot), *velocity.tolist(), *wanted.tolist(), moment)
    return (np.array(soon) - velocity) / moment


def _extra_velocity(since: np.ndarray, off: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Slope (2,) of the distances from the path within a window of time since the impact [m/s]."""
    within = (since >= begin) & (since <= end)
    if within.sum() < FEWEST_IN_WINDOW:
        return np.full(2, np.nan)
    return np.asarray(np.polyfit(since[within], off[within], 1)[0])


def _fit_path(around: RecordedPath, robot: Robot) -> _FittedPath:
    # costs more than all the rest to load
    from scipy.optimize import least_squares

    before, after = around.times <= -NEAR, around.times >= NEAR
    if min(before.sum(), after.sum()) < FEWEST_POSES:
        raise UnusableImpact("too few poses around it")
    used = before | after

    def off(unknowns: np.ndarray) -> np.ndarray:
        driven = _driven(unknowns, around.times, around.wanted, velocity_law(robot))
        return np.asarray(driven[:-2] - around.points)

    begin = [*around.points[0], *_slope(around, before), *_slope(around, after), 0.0]
    found = least_squares(lambda unknowns: off(unknowns)[used].ravel(), begin, method="lm", x_scale=_SCALES)
    freedom = 2 * used.sum() - len(_SCALES)
    misfit = float(np.sqrt(2.0 * found.cost / freedom))
    return _FittedPath(found.x, found.jac, misfit, -off(found.x))


def _slope(around: RecordedPath, side: np.ndarray) -> np.ndarray:
    return np.asarray(np.polyfit(around.times[side], around.points[side], 1)[0])


def _right_before(unknowns: np.ndarray, around: RecordedPath, robot: Robot) -> np.ndarray:
    """Position and velocity right before the impact (4,)."""
    driven = _driven(unknowns, around.times, around.wanted, velocity_law(robot))
    return np.asarray(driven[-2:].ravel())


def _slopes(unknowns: np.ndarray, around: RecordedPath, robot: Robot) -> np.ndarray:
    """(4, 7) derivatives of the velocities before and after by the unknowns."""
    # costs more than all the rest to load
    from scipy.optimize import approx_fprime

    before = approx_fprime(unknowns, lambda each: _right_before(each, around, robot)[2:], 1e-3 * _SCALES)
    return np.vstack([before, np.eye(2, len(unknowns), 4)])


class _Motion(NamedTuple):
    """Position [m] and velocity [m/s] of the robot, world frame."""

    x: float
    y: float
    vx: float
    vy: float


@njit
def _driven(unknowns: np.ndarray, times: np.ndarray, wanted: np.ndarray, wheels: VelocityLaw) -> np.ndarray:
    """(n + 2, 2): the path at the times, then position and velocity right before the impact."""
    last = len(times) - 1
    rows = np.zeros((last + 3, 2))
    motion = _Motion(unknowns[0], unknowns[1], unknowns[2], unknowns[3])
    impact = min(max(unknowns[6], times[0]), times[last])
    due = True
    rows[0, 0], rows[0, 1] = motion.x, motion.y
    for k in range(last):
        now = times[k]
        if due and impact <= times[k + 1]:
            motion = _drive(motion, wanted[k], impact - now, wheels)
            rows[last + 1, 0], rows[last + 1, 1] = motion.x, motion.y
            rows[last + 2, 0], rows[last + 2, 1] = motion.vx, motion.vy
            motion, now, due = _Motion(motion.x, motion.y, unknowns[4], unknowns[5]), impact, False
        motion = _drive(motion, wanted[k], times[k + 1] - now, wheels)
        rows[k + 1, 0], rows[k + 1, 1] = motion.x, motion.y
    return rows


@njit
def _drive(motion: _Motion, wanted: np.ndarray, duration: float, wheels: VelocityLaw) -> _Motion:
    """The motion after `duration` [s] under one command `wanted` (2,) [m/s]."""
    vx, vy = velocity_after(wheels, motion.vx, motion.vy, wanted[0], wanted[1], duration)
    x, y = motion.x + 0.5 * (motion.vx + vx) * duration, motion.y + 0.5 * (motion.vy + vy) * duration
    return _Motion(x, y, vx, vy)
