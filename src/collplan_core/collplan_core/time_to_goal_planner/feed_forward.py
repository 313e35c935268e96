"""The command that drives a robot with a lag along a timed path with contacts."""

import math

import numpy as np

from collplan_core.jit import njit

KINK_FACTOR, KINK_SPEED = 1.3, 0.08
"""A change of velocity from step to step beyond this factor of what the wheels make, and this speed, is a contact."""


@njit
def feed_forward(times: np.ndarray, path: np.ndarray, now: float, period: float, lag: float,
                         max_acceleration: float) -> tuple[float, float]:  # fmt: skip
    """The command that, held for `period`, makes a robot with a lag drive a timed path: found from the path alone.

    The velocity jumps where the path has a kink that the wheels cannot make: at a contact. A period that holds one
    belongs to its longer part. Something between both would brake before the contact and push back after it.

    Args:
        times: (n,) strictly rising [s]; path: (n, 2) [m]; now [s]; lag [s].
    """
    n = len(times)
    ux, uy, longest = 0.0, 0.0, 0.0
    i = min(max(int(np.searchsorted(times, now, side="right")) - 1, 0), n - 2)
    begun = now
    while i < n - 1 and begun < now + period:
        last = _smooth_until(times, path, i, max_acceleration)
        until = min(times[last], now + period)
        if until - begun > longest:
            longest = until - begun
            ax, ay = _velocity_at(times, path, i, last, begun, max_acceleration)
            bx, by = _velocity_at(times, path, i, last, until, max_acceleration)
            change = math.hypot(bx - ax, by - ay)
            gain = _lead(change, longest, lag, max_acceleration) / change if change > 1e-9 else 0.0
            ux, uy = ax + gain * (bx - ax), ay + gain * (by - ay)
        begun = max(begun, until)
        i = last
    return ux, uy


@njit
def _lead(change: float, duration: float, lag: float, max_acceleration: float) -> float:
    """How far the command must be ahead of the velocity for that to change by so much in a duration [m/s]."""
    linear, share = max_acceleration * lag, 1.0 - math.exp(-duration / lag)
    if change <= linear * share:
        return change / share
    # at full acceleration first: for how long has no closed form
    low, high = 0.0, duration
    for _ in range(20):
        middle = 0.5 * (low + high)
        if max_acceleration * middle + linear * (1.0 - math.exp(-(duration - middle) / lag)) < change:
            low = middle
        else:
            high = middle
    return linear + max_acceleration * high


@njit
def _mean_velocity(times: np.ndarray, path: np.ndarray, i: int) -> tuple[float, float]:
    """From sample i to the next one."""
    span = times[i + 1] - times[i]
    return (path[i + 1, 0] - path[i, 0]) / span, (path[i + 1, 1] - path[i, 1]) / span


@njit
def _smooth_until(times: np.ndarray, path: np.ndarray, first: int, max_acceleration: float) -> int:
    """The sample at which the first kink after sample `first` is, or the last one."""
    vx, vy = _mean_velocity(times, path, first)
    for i in range(first + 1, len(times) - 1):
        wx, wy = _mean_velocity(times, path, i)
        wheels = max_acceleration * 0.5 * (times[i + 1] - times[i - 1])
        if math.hypot(wx - vx, wy - vy) > KINK_FACTOR * wheels + KINK_SPEED:
            return i
        vx, vy = wx, wy
    return len(times) - 1


@njit
def _velocity_at(times: np.ndarray, path: np.ndarray, first: int, last: int, time: float, max_acceleration: float,
                 ) -> tuple[float, float]:  # fmt: skip
    """Velocity on the smooth stretch from sample `first` to `last`: linear between the middles of its steps."""
    i = min(max(int(np.searchsorted(times, time, side="right")) - 1, first), last - 1)
    vx, vy = _mean_velocity(times, path, i)
    middle = 0.5 * (times[i] + times[i + 1])
    j = i + 1 if time > middle else i - 1
    if not first <= j < last:
        j = 2 * i - j
    if not first <= j < last:
        return vx, vy
    wx, wy = _mean_velocity(times, path, j)
    share = (time - middle) / (0.5 * (times[j] + times[j + 1]) - middle)
    return vx + share * (wx - vx), vy + share * (wy - vy)
