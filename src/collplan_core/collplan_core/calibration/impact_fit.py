"""How fast the robot was right before and right after a hit, from the poses around it.

No pose of the hit itself is used: a ring gives way for some milliseconds. The poses from 120 to 20 ms before and from
20 to 120 ms after are met, by least squares, with one path that the wheels drive as commanded,

    dv/dt = (u - v) / lag, at most max_acceleration,

and whose velocity alone leaps, once, at an unknown time. At 100 Hz and 2 mm of noise either velocity is then known to
0.02 m/s by axis; a straight line instead of the commands' acceleration would be off by 0.1 m/s at 1.5 m/s^2.
"""

from dataclasses import dataclass
from math import exp, hypot

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Robot

NEAR, FAR = 0.02, 0.12
"""Poses so long before and after a hit are met [s]."""
FEWEST_POSES = 5
"""On either side."""
UNEXPLAINED = 0.02
"""Standard deviation of a velocity by what wheels and floor do beyond the commands, by axis [m/s] (assumed)."""
LARGEST_MISFIT = 1.6
"""Of the poses, in standard deviations; beyond it something else happened as well."""

_MOST_ROUNDS = 4
_STEPS = 4
"""Of the path between two poses."""
_SCALES = np.array([0.01, 0.01, 0.1, 0.1, 0.1, 0.1, 0.01])


class UnusableImpact(ValueError):
    """A hit from which no velocities can be had; the message says why."""


@dataclass(frozen=True, eq=False)
class RecordedPath:
    """Poses and what was commanded at each.

    Attributes:
        times: (n,) strictly rising [s].
        points: (n, 2) measured centres of the robot [m, world frame].
        wanted: (n, 2) velocity commanded from this pose to the next [m/s, world frame].
    """

    times: np.ndarray
    points: np.ndarray
    wanted: np.ndarray

    def between(self, begin: float, end: float) -> "RecordedPath":
        """The poses from `begin` to `end` [s]; times count from now on from the middle."""
        first, last = np.searchsorted(self.times, (begin, end))
        part = slice(int(first), int(last))
        return RecordedPath(self.times[part] - 0.5 * (begin + end), self.points[part], self.wanted[part])


@dataclass(frozen=True, eq=False)
class ImpactFit:
    """A hit, world frame.

    Attributes:
        time: when [s].
        position: (2,) centre of the robot then [m].
        before, after: (2,) velocity [m/s].
        covariance: (4, 4) of before and after [m^2/s^2].
    """

    time: float
    position: np.ndarray
    before: np.ndarray
    after: np.ndarray
    covariance: np.ndarray


def fit_impact(path: RecordedPath, time: float, robot: Robot, noise: float) -> ImpactFit:
    """The hit at about `time` [s]; `noise` is the standard deviation of a measured position by axis [m].

    Raises:
        UnusableHit: too few poses around it, no single moment that explains them, or a path that misses them.
    """
    for _ in range(_MOST_ROUNDS):
        around = path.between(time - FAR, time + FAR)
        unknowns, jacobian, misfit = _met(around, robot)
        time += float(unknowns[6])
        if abs(unknowns[6]) <= 0.5 * NEAR:
            return _checked(around, time, unknowns, jacobian, misfit, robot, noise)
    raise UnusableImpact("no single moment explains the poses around it")


def _checked(
    around: RecordedPath, time: float, unknowns: np.ndarray, jacobian: np.ndarray, misfit: float, robot: Robot,
    noise: float,
) -> ImpactFit:  # fmt: skip
    deviation = hypot(noise, UNEXPLAINED * 0.5 * (FAR - NEAR))
    if misfit > LARGEST_MISFIT * deviation:
        raise UnusableImpact("the poses around it are not those of one hit")
    variances = max(deviation, misfit) ** 2 * np.linalg.pinv(jacobian.T @ jacobian)
    slopes = _slopes(unknowns, around, robot)
    contact = _contact(unknowns, around, robot)
    covariance = slopes @ variances @ slopes.T + UNEXPLAINED**2 * np.eye(4)
    return ImpactFit(time, contact[:2], contact[2:], unknowns[4:6], covariance)


def _met(around: RecordedPath, robot: Robot) -> tuple[np.ndarray, np.ndarray, float]:
    """Position and velocity at the first pose, velocity after the hit, its time; the Jacobian; the misfit by axis."""
    # costs more than all the rest to load
    from scipy.optimize import least_squares

    before, after = around.times <= -NEAR, around.times >= NEAR
    if min(before.sum(), after.sum()) < FEWEST_POSES:
        raise UnusableImpact("too few poses around it")
    used = before | after

    def off(unknowns: np.ndarray) -> np.ndarray:
        driven = _driven(unknowns, around.times, around.wanted, robot.velocity_lag, robot.max_acceleration)
        return np.asarray((driven[:-2] - around.points)[used].ravel())

    begin = [*around.points[0], *_slope(around, before), *_slope(around, after), 0.0]
    found = least_squares(off, begin, method="lm", x_scale=_SCALES)
    freedom = 2 * used.sum() - len(_SCALES)
    return found.x, found.jac, float(np.sqrt(2.0 * found.cost / freedom))


def _slope(around: RecordedPath, side: np.ndarray) -> np.ndarray:
    return np.asarray(np.polyfit(around.times[side], around.points[side], 1)[0])


def _contact(unknowns: np.ndarray, around: RecordedPath, robot: Robot) -> np.ndarray:
    """Position and velocity right before the hit (4,)."""
    driven = _driven(unknowns, around.times, around.wanted, robot.velocity_lag, robot.max_acceleration)
    return np.asarray(driven[-2:].ravel())


def _slopes(unknowns: np.ndarray, around: RecordedPath, robot: Robot) -> np.ndarray:
    """(4, 7) of the velocities before and after by the unknowns."""
    slopes = np.zeros((4, len(unknowns)))
    slopes[2:, 4:6] = np.eye(2)
    for i, step in enumerate(1e-3 * _SCALES):
        shift = step * np.eye(len(unknowns))[i]
        ahead, behind = _contact(unknowns + shift, around, robot), _contact(unknowns - shift, around, robot)
        slopes[:2, i] = (ahead - behind)[2:] / (2.0 * step)
    return slopes


@njit
def _driven(unknowns, times, wanted, lag, limit):  # type: ignore[no-untyped-def]
    """(n + 2, 2): the path at the times, then position and velocity right before the hit."""
    last = len(times) - 1
    rows = np.zeros((last + 3, 2))
    x, y, vx, vy = unknowns[0], unknowns[1], unknowns[2], unknowns[3]
    hit = min(max(unknowns[6], times[0]), times[last])
    due = True
    rows[0, 0], rows[0, 1] = x, y
    for k in range(last):
        now = times[k]
        if due and hit <= times[k + 1]:
            x, y, vx, vy = _drive(x, y, vx, vy, wanted[k], hit - now, lag, limit)
            rows[last + 1, 0], rows[last + 1, 1], rows[last + 2, 0], rows[last + 2, 1] = x, y, vx, vy
            now, vx, vy, due = hit, unknowns[4], unknowns[5], False
        x, y, vx, vy = _drive(x, y, vx, vy, wanted[k], times[k + 1] - now, lag, limit)
        rows[k + 1, 0], rows[k + 1, 1] = x, y
    return rows


@njit
def _drive(x, y, vx, vy, wanted, duration, lag, limit):  # type: ignore[no-untyped-def]
    """Position and velocity after a duration under one command."""
    step = duration / _STEPS
    # the exact share of a first-order lag, so that a lag shorter than the step stays stable
    share = 1.0 - exp(-step / lag) if lag > 0.0 else 1.0
    for _ in range(_STEPS):
        change_x, change_y = share * (wanted[0] - vx), share * (wanted[1] - vy)
        change = hypot(change_x, change_y)
        if change > limit * step:
            change_x *= limit * step / change
            change_y *= limit * step / change
        x += (vx + 0.5 * change_x) * step
        y += (vy + 0.5 * change_y) * step
        vx += change_x
        vy += change_y
    return x, y, vx, vy
