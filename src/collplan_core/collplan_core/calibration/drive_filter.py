"""How likely measured poses are under the drive's law, for drives whose wheels make errors.

The law dv/dt = (u + e + b - v) / lag, at most max_acceleration, is followed by a Gaussian filter over position,
velocity, the wheels' error e and its mean b of the run. The error is redrawn once a command period. It must be within
the law: the largest acceleration cuts it off, so that a law fitted without it would find a longer lag. What the law
does to a Gaussian is integrated by Gauss-Hermite quadrature over u + e + b - v (K. Ito, K. Xiong, "Gaussian filters
for nonlinear filtering problems", IEEE Trans. Automatic Control 45, 2000).
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.velocity_law import SHORTEST_LAG, VelocityLaw, velocity_after

FIRST = 6
"""Poses from which a stretch begins: a line through them gives the first position and velocity."""
LARGEST_BIAS = 0.1
"""Standard deviation of the mean error of a run before its poses are seen, by axis [m/s] (assumed)."""

_UNKNOWNS = 8
"""Position, velocity, error and mean error, two each."""
_STRAIGHT = 0.01
"""Standard deviation of what a line through the first poses misses of the velocity [m/s]."""
_POINTS, _WEIGHTS = np.polynomial.hermite_e.hermegauss(5)
_SHARES = _WEIGHTS / _WEIGHTS.sum()


class DriveConstants(NamedTuple):
    """What poses depend on.

    Attributes:
        max_acceleration: [m/s^2]; lag: [s].
        wheel_error: standard deviation by axis of the wheels' error in one command period [m/s].
        pose_noise: standard deviation by axis of a measured position [m].
    """

    max_acceleration: float
    lag: float
    wheel_error: float
    pose_noise: float


class ErrorPeriod(NamedTuple):
    """When the wheels' error changes: `first` [s], and every `length` after it [s]."""

    first: float
    length: float


class Likelihood(NamedTuple):
    """The filter's result for a run.

    Attributes:
        by_stretch: (m,) logarithm of the likelihood of each stretch, up to a constant.
        misfit: mean square of the poses' distances from what was expected of them, in standard deviations; 1 where
            noise explains them.
        bias: (2,) mean error of the wheels [m/s, world frame].
    """

    by_stretch: np.ndarray
    misfit: float
    bias: np.ndarray


def likelihood(
    constants: DriveConstants,
    poses: tuple[np.ndarray, np.ndarray, np.ndarray],
    stretches: np.ndarray,
    period: ErrorPeriod,
) -> Likelihood:
    """Likelihood of the poses in `stretches` (m, 2), each from its first pose up to, not including, its last.

    Args:
        poses: times (n,) [s], points (n, 2) [m], commands (n, 2) in the world frame, each up to the next pose [m/s].
    """
    law = VelocityLaw(constants.max_acceleration, max(constants.lag, SHORTEST_LAG), 0.0, 1.0)
    by_stretch, bias = np.zeros(len(stretches)), np.zeros(2)
    misfit = _filtered(law, constants, poses, stretches, period, by_stretch, bias)
    return Likelihood(by_stretch, misfit, bias)


@njit
def _filtered(
    law: VelocityLaw,
    constants: DriveConstants,
    poses: tuple[np.ndarray, np.ndarray, np.ndarray],
    stretches: np.ndarray,
    period: ErrorPeriod,
    by_stretch: np.ndarray,
    bias: np.ndarray,
) -> float:
    """Fills `by_stretch` and `bias`; returns the misfit."""
    times, points, wanted = poses
    x, p = np.zeros(_UNKNOWNS), np.zeros((_UNKNOWNS, _UNKNOWNS))
    m, room, response = np.zeros((_UNKNOWNS, _UNKNOWNS)), np.zeros((_UNKNOWNS, _UNKNOWNS)), np.zeros(9)
    p[6, 6] = p[7, 7] = LARGEST_BIAS**2
    squares, count = 0.0, 0
    for s in range(len(stretches)):
        first = stretches[s, 0] + FIRST - 1
        _begin(x, p, law, constants, times[stretches[s, 0] : first + 1], points[stretches[s, 0] :], wanted[first])
        for k in range(first, stretches[s, 1] - 1):
            duration = times[k + 1] - times[k]
            _respond(response, x, p, law, wanted[k], duration)
            _advance(x, p, response, duration, m, room)
            if math.floor((times[k + 1] - period.first) / period.length) != math.floor(
                (times[k] - period.first) / period.length
            ):
                _redraw(x, p, constants.wheel_error)
            square, determinant = _correct(x, p, points[k + 1], constants.pose_noise, room)
            by_stretch[s] -= 0.5 * (square + math.log(determinant))
            squares += square
            count += 2
    bias[0], bias[1] = x[6], x[7]
    return squares / max(count, 1)


@njit
def _begin(
    x: np.ndarray,
    p: np.ndarray,
    law: VelocityLaw,
    constants: DriveConstants,
    times: np.ndarray,
    points: np.ndarray,
    wanted: np.ndarray,
) -> None:
    """State and covariance at the last of the first poses; what is known of the mean error stays."""
    middle = times.mean()
    spread = ((times - middle) ** 2).sum()
    late = times[-1] - middle
    velocity, centre = np.zeros(2), np.zeros(2)
    for k in range(len(times)):
        centre += points[k] / len(times)
        velocity += (times[k] - middle) / spread * points[k]
    vx, vy = velocity_after(law, velocity[0], velocity[1], wanted[0] + x[6], wanted[1] + x[7], late)
    x[0], x[1] = centre[0] + 0.5 * late * (velocity[0] + vx), centre[1] + 0.5 * late * (velocity[1] + vy)
    x[2], x[3], x[4], x[5] = vx, vy, 0.0, 0.0
    p[:6, :], p[:, :6] = 0.0, 0.0
    variance = constants.pose_noise**2
    for c in range(2):
        p[c, c] = variance * (1.0 / len(times) + late**2 / spread)
        p[c, 2 + c] = p[2 + c, c] = variance * late / spread
        p[2 + c, 2 + c] = variance / spread + _STRAIGHT**2
        p[4 + c, 4 + c] = constants.wheel_error**2


@njit
def _respond(
    response: np.ndarray, x: np.ndarray, p: np.ndarray, law: VelocityLaw, wanted: np.ndarray, duration: float
) -> None:
    """The change of velocity: mean (2,), slope (2, 2) by u + e + b - v, covariance xx, xy, yy of what that leaves."""
    gap_x, gap_y = wanted[0] + x[4] + x[6] - x[2], wanted[1] + x[5] + x[7] - x[3]
    xx, xy, yy = _gap_covariance(p, 0, 0), _gap_covariance(p, 0, 1), _gap_covariance(p, 1, 1)
    root_xx = math.sqrt(xx)
    root_yx = xy / root_xx
    root_yy = math.sqrt(max(yy - root_yx**2, 1e-18))
    mean_x = mean_y = squares_xx = squares_xy = squares_yy = 0.0
    by_xx = by_xy = by_yx = by_yy = 0.0
    for i in range(len(_POINTS)):
        for j in range(len(_POINTS)):
            z, w, share = _POINTS[i], _POINTS[j], _SHARES[i] * _SHARES[j]
            dx, dy = velocity_after(law, 0.0, 0.0, gap_x + root_xx * z, gap_y + root_yx * z + root_yy * w, duration)
            mean_x += share * dx
            mean_y += share * dy
            squares_xx += share * dx * dx
            squares_xy += share * dx * dy
            squares_yy += share * dy * dy
            by_xx += share * dx * z
            by_xy += share * dx * w
            by_yx += share * dy * z
            by_yy += share * dy * w
    response[0], response[1] = mean_x, mean_y
    response[3], response[5] = by_xy / root_yy, by_yy / root_yy
    response[2], response[4] = (by_xx - response[3] * root_yx) / root_xx, (by_yx - response[5] * root_yx) / root_xx
    response[6] = squares_xx - mean_x * mean_x - by_xx * by_xx - by_xy * by_xy
    response[7] = squares_xy - mean_x * mean_y - by_xx * by_yx - by_xy * by_yy
    response[8] = squares_yy - mean_y * mean_y - by_yx * by_yx - by_yy * by_yy


@njit
def _gap_covariance(p: np.ndarray, c: int, d: int) -> float:
    """Covariance of the components c and d of e + b - v."""
    errors = p[4 + c, 4 + d] + p[4 + c, 6 + d] + p[6 + c, 4 + d] + p[6 + c, 6 + d]
    return p[2 + c, 2 + d] + errors - p[2 + c, 4 + d] - p[2 + c, 6 + d] - p[4 + c, 2 + d] - p[6 + c, 2 + d]


@njit
def _advance(
    x: np.ndarray, p: np.ndarray, response: np.ndarray, duration: float, m: np.ndarray, room: np.ndarray
) -> None:
    """State and covariance after `duration` [s]; `m` and `room` are written over."""
    half = 0.5 * duration
    for i in range(_UNKNOWNS):
        for j in range(_UNKNOWNS):
            m[i, j] = 1.0 if i == j else 0.0
    for c in range(2):
        x[c] += duration * x[2 + c] + half * response[c]
        x[2 + c] += response[c]
        m[c, 2 + c] = duration
        for d in range(2):
            slope = response[2 + 2 * c + d]
            m[2 + c, 2 + d] -= slope
            m[2 + c, 4 + d] = m[2 + c, 6 + d] = slope
            m[c, 2 + d] -= half * slope
            m[c, 4 + d] = m[c, 6 + d] = half * slope
    for i in range(_UNKNOWNS):
        for j in range(_UNKNOWNS):
            total = 0.0
            for k in range(_UNKNOWNS):
                total += m[i, k] * p[k, j]
            room[i, j] = total
    for i in range(_UNKNOWNS):
        for j in range(i + 1):
            total = 0.0
            for k in range(_UNKNOWNS):
                total += room[i, k] * m[j, k]
            p[i, j] = p[j, i] = total
    for c in range(2):
        for d in range(2):
            left = response[6 + c + d]
            p[2 + c, 2 + d] += left
            p[c, 2 + d] += half * left
            p[2 + c, d] += half * left
            p[c, d] += half * half * left


@njit
def _redraw(x: np.ndarray, p: np.ndarray, wheel_error: float) -> None:
    """The wheels' error begins anew."""
    for c in range(2):
        x[4 + c] = 0.0
        for i in range(_UNKNOWNS):
            p[4 + c, i] = p[i, 4 + c] = 0.0
        p[4 + c, 4 + c] = wheel_error**2


@njit
def _correct(x: np.ndarray, p: np.ndarray, point: np.ndarray, noise: float, room: np.ndarray) -> tuple[float, float]:
    """Takes a measured point (2,) in; its squared distance in standard deviations, and their determinant [m^4]."""
    xx, xy, yy = p[0, 0] + noise**2, p[0, 1], p[1, 1] + noise**2
    determinant = xx * yy - xy * xy
    off_x, off_y = point[0] - x[0], point[1] - x[1]
    pull_x, pull_y = (yy * off_x - xy * off_y) / determinant, (xx * off_y - xy * off_x) / determinant
    square = off_x * pull_x + off_y * pull_y
    for i in range(_UNKNOWNS):
        x[i] += p[i, 0] * pull_x + p[i, 1] * pull_y
        room[i, 0], room[i, 1] = p[i, 0], p[i, 1]
        room[i, 2] = (p[i, 0] * yy - p[i, 1] * xy) / determinant
        room[i, 3] = (p[i, 1] * xx - p[i, 0] * xy) / determinant
    for i in range(_UNKNOWNS):
        for j in range(_UNKNOWNS):
            p[i, j] -= room[i, 2] * room[j, 0] + room[i, 3] * room[j, 1]
    return square, determinant
