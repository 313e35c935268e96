"""A bank of filters, each of which follows the robot under the velocity law of one assumed drive, in place.

A model's row holds the mean of its Gaussian, position and velocity, and its covariance. The wheels' error is white to
it: it is renewed each command period, while a drive answers within its lag. What the law's saturation does to a
Gaussian is linearised statistically: the answer along the gap between command and velocity is the smaller of the lag's
and the largest acceleration's, of which mean, slope and variance under a normal gap have closed forms. Where nothing
saturates, models that differ in the largest acceleration alone foresee the same.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit

X, Y, VX, VY, XX, XY, YY, X_VX, X_VY, Y_VX, Y_VY, VV_XX, VV_XY, VV_YY = range(14)
"""Columns of a row: mean [m], [m/s], and covariance of the position, of it with the velocity, and of the velocity."""
ROW = 14
WHEEL_ERROR, ERROR_TIME = 0.067, 0.06
"""Standard deviation of the wheels' error by axis [m/s], and the time for which it holds [s] (assumed)."""
ROUGH, ROUGH_TIME = 0.04, 0.3
"""Standard deviation of the largest acceleration as a share of it, and the time for which it holds [s]: drives lie
between the nodes of the grid, and none has the same one at each place. Without it a second at full acceleration would
leave no model that explains the poses."""


class ScoreLaw(NamedTuple):
    """How positions move scores, of a grid with so many accelerations and lags for each delay.

    Attributes:
        most: most by which one moves a score.
        deepest: most by which a score is behind the best, but for neighbours in acceleration: between them it is read
            off.
    """

    accelerations: int
    lags: int
    most: float
    deepest: float


@njit
def foresee(
    bank: np.ndarray,
    delays: np.ndarray,
    accelerations: np.ndarray,
    lags: np.ndarray,
    commands: np.ndarray,
    begin: float,
    end: float,
    yaw: float,
) -> None:
    """Moves every model from `begin` to `end` [s], under the mean of the commands that act then.

    Args:
        bank: (d n m, ROW), a row for each of delays (d,) [s], accelerations (n,) [m/s^2] and lags (m,) [s].
        commands: (k, 3) when each was sent [s] and its velocity [m/s, body frame]; rest before these.
        yaw: heading of the body [rad].
    """
    c, s, dt, row = math.cos(yaw), math.sin(yaw), end - begin, 0
    shares = 1.0 - np.exp(-dt / lags)
    for delay in delays:
        x, y = _mean_command(commands, begin - delay, end - delay)
        ux, uy = c * x - s * y, s * x + c * y
        for a_max in accelerations:
            for share in shares:
                _advance(bank, row, a_max, share, ux, uy, dt)
                row += 1


@njit
def _mean_command(commands: np.ndarray, begin: float, end: float) -> tuple[float, float]:
    """Mean of the commands from `begin` to `end` [s]."""
    x, y, until = 0.0, 0.0, end
    for k in range(len(commands) - 1, -1, -1):
        since = max(commands[k, 0], begin)
        if since < until:
            x, y = x + (until - since) * commands[k, 1], y + (until - since) * commands[k, 2]
            until = since
        if until <= begin:
            break
    return x / (end - begin), y / (end - begin)


@njit
def _advance(bank: np.ndarray, m: int, a_max: float, share: float, ux: float, uy: float, dt: float) -> None:
    """Model m after dt [s], in which `share` of a small gap closes, under command u [m/s]."""
    vx, vy = bank[m, VX], bank[m, VY]
    vxx, vxy, vyy = bank[m, VV_XX], bank[m, VV_XY], bank[m, VV_YY]
    gx, gy = ux - vx, uy - vy
    gap = math.sqrt(gx * gx + gy * gy)
    dx, dy = (gx / gap, gy / gap) if gap > 1e-9 else (1.0, 0.0)
    error = WHEEL_ERROR * WHEEL_ERROR
    spread = math.sqrt(dx * dx * vxx + 2.0 * dx * dy * vxy + dy * dy * vyy + error)
    # the smaller of a normal gap and the one from which the drive saturates
    z = (a_max * dt / share - gap) / spread
    slope = 0.5 * math.erfc(-z / math.sqrt(2.0))
    density = math.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi)
    mean = z * (1.0 - slope) - density
    left = slope - z * density + z * z * (1.0 - slope) - mean * mean - slope * slope
    change = share * (gap + spread * mean)
    along = share * slope
    across = min(share, max(change, 0.0) / gap) if gap > 2.0 * spread else share
    sxx, syy = along * dx * dx + across * dy * dy, along * dy * dy + across * dx * dx
    sxy = (along - across) * dx * dy
    axx, axy, ayy = 1.0 - sxx, -sxy, 1.0 - syy
    bxx, bxy, byy = dt * (1.0 - 0.5 * sxx), -0.5 * dt * sxy, dt * (1.0 - 0.5 * syy)
    bank[m, X] += dt * (vx + 0.5 * change * dx)
    bank[m, Y] += dt * (vy + 0.5 * change * dy)
    bank[m, VX], bank[m, VY] = vx + change * dx, vy + change * dy

    cxx, cxy, cyx, cyy = bank[m, X_VX], bank[m, X_VY], bank[m, Y_VX], bank[m, Y_VY]
    # covariance of the velocity with the position after the step
    nxx, nxy = cxx + bxx * vxx + bxy * vxy, cxy + bxx * vxy + bxy * vyy
    nyx, nyy = cyx + bxy * vxx + byy * vxy, cyy + bxy * vxy + byy * vyy
    bank[m, XX] += bxx * (cxx + nxx) + bxy * (cxy + nxy)
    bank[m, XY] += bxx * cyx + bxy * cyy + nxx * bxy + nxy * byy
    bank[m, YY] += bxy * (cyx + nyx) + byy * (cyy + nyy)
    bank[m, X_VX], bank[m, X_VY] = nxx * axx + nxy * axy, nxx * axy + nxy * ayy
    bank[m, Y_VX], bank[m, Y_VY] = nyx * axx + nyy * axy, nyx * axy + nyy * ayy
    pxx, pxy = axx * vxx + axy * vxy, axx * vxy + axy * vyy
    pyx, pyy = axy * vxx + ayy * vxy, axy * vxy + ayy * vyy
    held = error * ERROR_TIME / dt
    kink = max(left, 0.0) * (share * spread) ** 2 + (1.0 - slope) * (ROUGH * a_max) ** 2 * ROUGH_TIME * dt
    qxx, qyy = held * (sxx * sxx + sxy * sxy) + kink * dx * dx, held * (syy * syy + sxy * sxy) + kink * dy * dy
    qxy = held * sxy * (sxx + syy) + kink * dx * dy
    bank[m, VV_XX] = pxx * axx + pxy * axy + qxx
    bank[m, VV_XY] = pxx * axy + pxy * ayy + qxy
    bank[m, VV_YY] = pyx * axy + pyy * ayy + qyy


@njit
def judge(bank: np.ndarray, x: float, y: float, variance: float, told: np.ndarray, best: int) -> tuple[float, float]:
    """Fills the logarithm of each model's likelihood (m,) of a position [m] with a variance by axis [m^2].

    Returns:
        square of its distance from what a model `best` foresaw, in standard deviations, and the smallest of all.
    """
    of_best = least = math.inf
    for m in range(len(bank)):
        xx, xy, yy = bank[m, XX] + variance, bank[m, XY], bank[m, YY] + variance
        determinant, ox, oy = xx * yy - xy * xy, x - bank[m, X], y - bank[m, Y]
        square = (yy * ox * ox - 2.0 * xy * ox * oy + xx * oy * oy) / determinant
        told[m] = -0.5 * (square + math.log(determinant))
        least = min(least, square)
        if m == best:
            of_best = square
    return of_best, least


@njit
def learn(scores: np.ndarray, prior: np.ndarray, told: np.ndarray, law: ScoreLaw, kept: float, misfit: float) -> int:
    """Adds what a position told (m,) to the scores (m,), of which the best is 0, and returns that one.

    Args:
        prior: (m,) to which the rest of the share `kept` of the scores fades.
        misfit: mean square of the distances; above 1 it makes each position worth less.
    """
    most, worth, top, best = told.max(), 1.0 / max(1.0, misfit), -math.inf, 0
    for m in range(len(scores)):
        scores[m] = prior[m] + kept * (scores[m] - prior[m]) + worth * max(told[m] - most, -law.most)
        if scores[m] > top:
            top, best = scores[m], m
    row = (best // law.lags) % law.accelerations
    for m in range(len(scores)):
        scores[m] -= top
        if abs((m // law.lags) % law.accelerations - row) > 1:
            scores[m] = max(scores[m], -law.deepest)
    return best


@njit
def take(bank: np.ndarray, x: float, y: float, variance: float) -> None:
    """Every model takes a measured position [m]."""
    for m in range(len(bank)):
        xx, xy, yy = bank[m, XX], bank[m, XY], bank[m, YY]
        sxx, syy = xx + variance, yy + variance
        determinant = sxx * syy - xy * xy
        ixx, ixy, iyy = syy / determinant, -xy / determinant, sxx / determinant
        ox, oy = x - bank[m, X], y - bank[m, Y]
        wx, wy = ixx * ox + ixy * oy, ixy * ox + iyy * oy
        cxx, cxy, cyx, cyy = bank[m, X_VX], bank[m, X_VY], bank[m, Y_VX], bank[m, Y_VY]
        bank[m, X] += xx * wx + xy * wy
        bank[m, Y] += xy * wx + yy * wy
        bank[m, VX] += cxx * wx + cyx * wy
        bank[m, VY] += cxy * wx + cyy * wy
        # gains: of the position (k), of the velocity (l)
        kxx, kxy = xx * ixx + xy * ixy, xx * ixy + xy * iyy
        kyx, kyy = xy * ixx + yy * ixy, xy * ixy + yy * iyy
        lxx, lxy = cxx * ixx + cyx * ixy, cxx * ixy + cyx * iyy
        lyx, lyy = cxy * ixx + cyy * ixy, cxy * ixy + cyy * iyy
        bank[m, XX] -= kxx * xx + kxy * xy
        bank[m, XY] -= kxx * xy + kxy * yy
        bank[m, YY] -= kyx * xy + kyy * yy
        bank[m, X_VX] -= kxx * cxx + kxy * cyx
        bank[m, X_VY] -= kxx * cxy + kxy * cyy
        bank[m, Y_VX] -= kyx * cxx + kyy * cyx
        bank[m, Y_VY] -= kyx * cxy + kyy * cyy
        bank[m, VV_XX] -= lxx * cxx + lxy * cyx
        bank[m, VV_XY] -= lxx * cxy + lxy * cyy
        bank[m, VV_YY] -= lyx * cxy + lyy * cyy
