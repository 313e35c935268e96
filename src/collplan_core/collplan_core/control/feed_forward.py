"""The command that drives a robot with a lag along a timed path with contacts."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.velocity_law import VelocityLaw, command_lead

FULL, TOO_MUCH = 0.93, 1.02
"""A change of velocity between these shares of what the wheels can make takes full acceleration throughout."""
KINK_FACTOR, KINK_SPEED = 1.3, 0.08
"""A change of velocity from step to step beyond this factor of what the wheels make, and this speed, is a contact."""


@njit
def feed_forward(
    times: np.ndarray, path: np.ndarray, now: float, period: float, wheels: VelocityLaw, max_speed: float, lead: float
) -> tuple[float, float]:
    """Returns the command that, held for `period`, makes a robot with a lag drive a timed path; from the path alone.

    Where the path takes full acceleration throughout, how far the command leads the velocity does not matter to a robot
    without errors. An error of the velocity aimed at turns it the less, the farther that is: there it leads by up to
    `lead` [m/s], as far as `max_speed` [m/s] allows.

    The velocity jumps where the path has a kink that the wheels cannot make: at a contact. A period that holds one
    belongs to its longer part. Something between both would brake before the contact and push back after it.

    Args:
        times: (n,) strictly rising [s]; path: (n, 2) at these times [m]; now, period: [s].
    """
    n = len(times)
    ux, uy, longest = 0.0, 0.0, 0.0
    i = min(max(int(np.searchsorted(times, now, side="right")) - 1, 0), n - 2)
    begin = now
    while i < n - 1 and begin < now + period:
        last = _smooth_until(times, path, i, wheels.max_acceleration)
        until = min(times[last], now + period)
        if until - begin > longest:
            longest = until - begin
            ax, ay = _velocity_at(times, path, i, last, begin)
            bx, by = _velocity_at(times, path, i, last, until)
            change = math.hypot(bx - ax, by - ay)
            ux, uy = ax, ay
            if change > 1e-9:
                dx, dy, ahead = (bx - ax) / change, (by - ay) / change, command_lead(wheels, change, longest)
                if FULL < change / (wheels.max_acceleration * longest) < TOO_MUCH:
                    ahead = max(ahead, min(lead, _room(ax, ay, dx, dy, max_speed)))
                ux, uy = ax + ahead * dx, ay + ahead * dy
        begin = max(begin, until)
        i = last
    return ux, uy


@njit
def _room(vx: float, vy: float, dx: float, dy: float, max_speed: float) -> float:
    """Largest change of the velocity v along the unit direction d up to max_speed [m/s]."""
    along = vx * dx + vy * dy
    root = along * along + max_speed * max_speed - vx * vx - vy * vy
    return math.sqrt(root) - along if root > 0.0 else 0.0


@njit
def _mean_velocity(times: np.ndarray, path: np.ndarray, i: int) -> tuple[float, float]:
    """Velocity from sample i to the next one."""
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
def _velocity_at(times: np.ndarray, path: np.ndarray, first: int, last: int, time: float) -> tuple[float, float]:
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
