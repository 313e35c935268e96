"""Likelihood of measured poses under the velocity law, for drives whose wheels make errors.

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

_GAP = np.hstack([np.zeros((2, 2)), -np.eye(2), np.eye(2), np.eye(2)])
"""Matrix that gives the law's u + e + b - v from a state: position, velocity, error and mean error, two each."""
_STRAIGHT = 0.01
"""Standard deviation of what a line through the first poses misses of the velocity [m/s]."""
_POINTS, _WEIGHTS = np.polynomial.hermite_e.hermegauss(5)
_SHARES = _WEIGHTS / _WEIGHTS.sum()


class DriveConstants(NamedTuple):
    """Constants that measured poses depend on.

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
    """Times at which the wheels' error changes: `first` [s], and every `length` after it [s]."""

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
    noise = constants.pose_noise**2
    x, p = np.zeros(8), np.zeros((8, 8))
    p[6, 6] = p[7, 7] = LARGEST_BIAS**2
    squares, count = 0.0, 0
    for s in range(len(stretches)):
        first = stretches[s, 0] + FIRST - 1
        x, p = _begun(
            x, p, law, constants, times[stretches[s, 0] : first + 1], points[stretches[s, 0] :], wanted[first]
        )
        for k in range(first, stretches[s, 1] - 1):
            x, p = _advanced(x, p, law, wanted[k], times[k + 1] - times[k])
            if (times[k + 1] - period.first) // period.length != (times[k] - period.first) // period.length:
                _redraw(x, p, constants.wheel_error)
            xx, xy, yy = p[0, 0] + noise, p[0, 1], p[1, 1] + noise
            determinant = xx * yy - xy * xy
            off = points[k + 1] - x[:2]
            inverse = np.array([[yy, -xy], [-xy, xx]]) / determinant
            gain = np.ascontiguousarray(p[:, :2]) @ inverse
            square = off @ inverse @ off
            x = x + gain @ off
            p = p - gain @ p[:2]
            by_stretch[s] -= 0.5 * (square + math.log(determinant))
            squares += square
            count += 2
    bias[:] = x[6:]
    return squares / max(count, 1)


@njit
def _begun(
    x: np.ndarray,
    p: np.ndarray,
    law: VelocityLaw,
    constants: DriveConstants,
    times: np.ndarray,
    points: np.ndarray,
    wanted: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """State and covariance at the last of the first poses; what is known of the mean error stays."""
    n, since = len(times), times - times.mean()
    spread, late = (since**2).sum(), since[-1]
    begun, covariance = np.zeros(8), np.zeros((8, 8))
    begun[6:], covariance[6:, 6:] = x[6:], p[6:, 6:]
    variance = constants.pose_noise**2
    for c in range(2):
        begun[c], begun[2 + c] = points[:n, c].mean(), (since * points[:n, c]).sum() / spread
        covariance[c, c] = variance * (1.0 / n + late**2 / spread)
        covariance[c, 2 + c] = covariance[2 + c, c] = variance * late / spread
        covariance[2 + c, 2 + c] = variance / spread + _STRAIGHT**2
        covariance[4 + c, 4 + c] = constants.wheel_error**2
    after = velocity_after(law, begun[2], begun[3], wanted[0] + x[6], wanted[1] + x[7], late)
    for c in range(2):
        begun[c] += 0.5 * late * (begun[2 + c] + after[c])
        begun[2 + c] = after[c]
    return begun, covariance


@njit
def _response(
    gap: np.ndarray, covariance: np.ndarray, law: VelocityLaw, duration: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The change of velocity by a gap u + e + b - v: mean (2,), slope (2, 2), covariance (2, 2) of what that leaves."""
    root_xx = math.sqrt(covariance[0, 0])
    root_yx = covariance[0, 1] / root_xx
    root_yy = math.sqrt(max(covariance[1, 1] - root_yx**2, 1e-18))
    mean_x = mean_y = squares_xx = squares_xy = squares_yy = 0.0
    by_xx = by_xy = by_yx = by_yy = 0.0
    for i in range(len(_POINTS)):
        for j in range(len(_POINTS)):
            z, w, share = _POINTS[i], _POINTS[j], _SHARES[i] * _SHARES[j]
            dx, dy = velocity_after(law, 0.0, 0.0, gap[0] + root_xx * z, gap[1] + root_yx * z + root_yy * w, duration)
            mean_x += share * dx
            mean_y += share * dy
            squares_xx += share * dx * dx
            squares_xy += share * dx * dy
            squares_yy += share * dy * dy
            by_xx += share * dx * z
            by_xy += share * dx * w
            by_yx += share * dy * z
            by_yy += share * dy * w
    slope_xy, slope_yy = by_xy / root_yy, by_yy / root_yy
    slope_xx, slope_yx = (by_xx - slope_xy * root_yx) / root_xx, (by_yx - slope_yy * root_yx) / root_xx
    left_xx = squares_xx - mean_x * mean_x - by_xx * by_xx - by_xy * by_xy
    left_xy = squares_xy - mean_x * mean_y - by_xx * by_yx - by_xy * by_yy
    left_yy = squares_yy - mean_y * mean_y - by_yx * by_yx - by_yy * by_yy
    slope, left = (
        np.array([[slope_xx, slope_xy], [slope_yx, slope_yy]]),
        np.array([[left_xx, left_xy], [left_xy, left_yy]]),
    )
    return np.array([mean_x, mean_y]), slope, left


@njit
def _advanced(
    x: np.ndarray, p: np.ndarray, law: VelocityLaw, wanted: np.ndarray, duration: float
) -> tuple[np.ndarray, np.ndarray]:
    """State and covariance after `duration` [s]."""
    mean, slope, left = _response(wanted + _GAP @ x, _GAP @ p @ _GAP.T, law, duration)
    goes_on, changed = np.eye(8), np.zeros((8, 2))
    for c in range(2):
        goes_on[c, 2 + c] = duration
        changed[c, c], changed[2 + c, c] = 0.5 * duration, 1.0
    matrix = goes_on + changed @ slope @ _GAP
    return goes_on @ x + changed @ mean, matrix @ p @ matrix.T + changed @ left @ changed.T


@njit
def _redraw(x: np.ndarray, p: np.ndarray, wheel_error: float) -> None:
    """The wheels' error begins anew."""
    x[4:6], p[4:6, :], p[:, 4:6] = 0.0, 0.0, 0.0
    p[4, 4] = p[5, 5] = wheel_error**2
