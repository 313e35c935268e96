"""A bank of filters, each of which follows the robot under the velocity law of one assumed drive, in place.

Its state is x, y, vx, vy. The wheels' error is white to it. What the law's saturation does to a Gaussian is linearised
statistically: along the gap between command and velocity the answer is the smaller of the lag's and the largest
acceleration's, of which mean, slope and variance under a normal gap have closed forms. Where nothing saturates, models
that differ in the largest acceleration alone foresee the same.

Models far behind sleep: they cost nothing, and their scores fade to the prior alone. One that has come near again, or
all when the best explains the poses no longer, wake with the state of the best.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.plane import rotate

WHEEL_ERROR, ERROR_TIME = 0.067, 0.06
"""Standard deviation of the wheels' error by axis [m/s], and the time for which it holds [s] (assumed)."""
ROUGH, ROUGH_TIME = 0.04, 0.3
"""Standard deviation of the largest acceleration as a share of it, and the time for which it holds [s]: drives lie
between the nodes of the grid. Without it a second at full acceleration would leave no model that explains the poses."""

BACK = 0.8
"""Share of the score behind the best at which a model falls asleep, at which it wakes: that takes 4 s of fading."""


class Bank(NamedTuple):
    """Filters of all combinations of d delays, n largest accelerations and k lags, in this order."""

    delays: np.ndarray  # (d,) [s]
    accelerations: np.ndarray  # (n,) [m/s^2]
    lags: np.ndarray  # (k,) [s]
    means: np.ndarray  # (d n k, 4) [m], [m/s]
    covariances: np.ndarray  # (d n k, 4, 4)
    scores: np.ndarray  # scores, prior: (d n k,) logarithms of posterior and prior, the best score being 0
    prior: np.ndarray
    told: np.ndarray  # (d n k,) logarithm of the likelihood of the newest position; of a model asleep that of the best
    awake: np.ndarray  # (d n k,) bool


@njit
def compare(
    fields: tuple, commands: np.ndarray, begin: float, pose: tuple, variance: float, best: int, most: tuple
) -> tuple[float, float, bool]:
    """Moves the models awake from `begin` on [s], and lets them take a pose but for an outlier.

    Returns the square of the best one's error, how far apart the models are by what the pose told, and if it is an
    outlier.

    Args:
        fields: fields of a Bank: a plain tuple costs a fifth of a named one to hand over.
        commands: as in `foresee`.
        pose: stamp [s], x, y [m], yaw [rad]; variance: of its position by axis [m^2]; best: the best model.
        most: square of an error, of `judge`, of an outlier, and by how much the best may be behind the nearest.
    """
    bank, (stamp, x, y, yaw), (outlier, behind) = Bank(*fields), pose, most
    foresee(bank, commands, begin, stamp, yaw)
    square, least = judge(bank, x, y, variance, best)
    is_outlier = min(square, least + behind) > outlier
    if not is_outlier:
        take(bank, x, y, variance)
    return square, bank.told.max() - bank.told.min(), is_outlier


@njit
def foresee(bank: Bank, commands: np.ndarray, begin: float, end: float, yaw: float) -> None:
    """Moves the models awake from `begin` to `end` [s], under the mean of the commands that act then.

    Commands (k, 3): when each was sent [s] and its velocity [m/s, body frame]; rest before these. Heading: yaw [rad].
    """
    dt, m, room = end - begin, 0, np.zeros((8, 2))
    shares = 1.0 - np.exp(-dt / bank.lags)
    for delay in bank.delays:
        x, y = _mean_command(commands, begin - delay, end - delay)
        u = rotate(x, y, yaw)
        for a_max in bank.accelerations:
            for share in shares:
                if bank.awake[m]:
                    _advance(bank.means[m], bank.covariances[m], a_max, share, u, dt, room)
                m += 1


@njit
def _mean_command(commands: np.ndarray, begin: float, end: float) -> tuple[float, float]:
    """Mean of the commands from `begin` to `end` [s]."""
    x, y, until = 0.0, 0.0, end
    for k in range(len(commands) - 1, -1, -1):
        if until <= begin:
            break
        if commands[k, 0] < until:
            since = max(commands[k, 0], begin)
            x, y = x + (until - since) * commands[k, 1], y + (until - since) * commands[k, 2]
            until = since
    return x / (end - begin), y / (end - begin)


@njit
def _advance(
    mean: np.ndarray, p: np.ndarray, a_max: float, share: float, u: tuple[float, float], dt: float, room: np.ndarray
) -> None:
    """Mean and covariance p after dt [s], in which `share` of a small gap closes, under command u [m/s]."""
    # `room` (8, 2): how position and velocity after it follow from the velocity before, and a product.
    gx, gy = u[0] - mean[2], u[1] - mean[3]
    gap, error = math.sqrt(gx * gx + gy * gy), WHEEL_ERROR * WHEEL_ERROR
    direction = (gx / gap, gy / gap) if gap > 1e-9 else (1.0, 0.0)
    dx, dy = direction
    spread = math.sqrt(dx * dx * p[2, 2] + 2.0 * dx * dy * p[2, 3] + dy * dy * p[3, 3] + error)
    # the smaller of a normal gap and the one from which the drive saturates, in `spread` around the gap
    z = (a_max * dt / share - gap) / spread
    slope = 0.5 * math.erfc(-z / math.sqrt(2.0))
    density = math.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi)
    middle = z * (1.0 - slope) - density
    left = slope - z * density + z * z * (1.0 - slope) - middle * middle - slope * slope
    change, along = share * (gap + spread * middle), share * slope
    across = min(share, max(change, 0.0) / gap) if gap > 2.0 * spread else share
    rough = max(left, 0.0) * (share * spread) ** 2 + (1.0 - slope) * (ROUGH * a_max) ** 2 * ROUGH_TIME * dt
    noise = along * along * error * ERROR_TIME / dt + rough, across * across * error * ERROR_TIME / dt
    for i in range(2):
        mean[i] += dt * (mean[2 + i] + 0.5 * change * direction[i])
        mean[2 + i] += change * direction[i]
        for j in range(2):
            same = 1.0 if i == j else 0.0
            answer = across * same + (along - across) * direction[i] * direction[j]
            room[i, j], room[2 + i, j] = dt * (same - 0.5 * answer), same - answer
    for i in range(4):
        for j in range(2):
            before = p[i, 2 + j] if i < 2 else 0.0
            room[4 + i, j] = before + room[i, 0] * p[2, 2 + j] + room[i, 1] * p[3, 2 + j]
    for i in range(2):
        for j in range(2):
            for k in range(2):
                p[i, j] += room[i, k] * p[j, 2 + k] + room[4 + i, k] * room[j, k]
    for i in range(4):
        for j in range(2):
            p[i, 2 + j] = p[2 + j, i] = room[4 + i, 0] * room[2 + j, 0] + room[4 + i, 1] * room[2 + j, 1]
    for i in range(2):
        for j in range(2):
            same = noise[1] if i == j else 0.0
            p[2 + i, 2 + j] += same + (noise[0] - noise[1]) * direction[i] * direction[j]


@njit
def judge(bank: Bank, x: float, y: float, variance: float, best: int) -> tuple[float, float]:
    """Fills what a position [m] of a variance by axis [m^2] tells; returns two squared errors in standard deviations.

    They are of what a model `best` foresaw, and the smallest of all.
    """
    of_best = least = math.inf
    for m in np.flatnonzero(bank.awake):
        p = bank.covariances[m]
        xx, xy, yy = p[0, 0] + variance, p[0, 1], p[1, 1] + variance
        determinant, ox, oy = xx * yy - xy * xy, x - bank.means[m, 0], y - bank.means[m, 1]
        square = (yy * ox * ox - 2.0 * xy * ox * oy + xx * oy * oy) / determinant
        bank.told[m] = -0.5 * (square + math.log(determinant))
        of_best, least = square if m == best else of_best, min(least, square)
    bank.told[~bank.awake] = bank.told[best]
    return of_best, least


@njit
def take(bank: Bank, x: float, y: float, variance: float) -> None:
    """Every model awake takes the position."""
    rows = np.zeros((2, 4))
    for m in np.flatnonzero(bank.awake):
        mean, p = bank.means[m], bank.covariances[m]
        for j in range(4):
            rows[0, j], rows[1, j] = p[0, j], p[1, j]
        xx, xy, yy = rows[0, 0] + variance, rows[0, 1], rows[1, 1] + variance
        determinant, ox, oy = xx * yy - xy * xy, x - mean[0], y - mean[1]
        for i in range(4):
            gain_x = (rows[0, i] * yy - rows[1, i] * xy) / determinant
            gain_y = (rows[1, i] * xx - rows[0, i] * xy) / determinant
            mean[i] += gain_x * ox + gain_y * oy
            for j in range(4):
                p[i, j] -= gain_x * rows[0, j] + gain_y * rows[1, j]


@njit
def learn(fields: tuple, kept: float, worth: float, most: float, deepest: float, behind: float) -> int:
    """Adds what the position told to the scores, lets sleep what is `behind` the best, and returns the best.

    Args:
        fields: fields of a Bank.
        kept: share of the scores that is kept; the rest fades to the prior.
        worth: weight of a position; most: most by which one moves a score.
        deepest: most by which a score is behind the best, but for neighbours in acceleration: between them it is read
            off.
    """
    bank = Bank(*fields)
    scores, prior, told = bank.scores, bank.prior, bank.told
    top, k, n = told.max(), len(bank.lags), len(bank.accelerations)
    for m in range(len(scores)):
        scores[m] = prior[m] + kept * (scores[m] - prior[m]) + worth * max(told[m] - top, -most)
    best = int(scores.argmax())
    scores -= scores[best]
    for row in range(0, len(scores), k):
        if abs(row // k % n - best // k % n) > 1:
            scores[row : row + k] = np.maximum(scores[row : row + k], -deepest)
    wake(bank, best, behind)
    return best


@njit
def wake(bank: Bank, best: int, behind: float) -> None:
    """Wakes the models less than `behind` the best, and lets the others sleep.

    Beside it in acceleration those wake that are near the best there: between them it is read off.
    """
    k, n, gaps = len(bank.lags), len(bank.accelerations), -bank.scores
    by_acceleration, at = gaps.reshape((-1, n, k)), best // k % n
    for a in range(max(at - 1, 0), min(at + 2, n)):
        by_acceleration[:, a] -= by_acceleration[:, a].min()
    near = gaps < np.where(bank.awake, behind, BACK * behind)
    for m in np.flatnonzero(near & ~bank.awake):
        bank.means[m], bank.covariances[m] = bank.means[best], bank.covariances[best]
    bank.awake[:] = near
