"""Following a timed reference: PID with look-ahead, saturation that keeps the direction, body frame. Paper: III-B."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.params import Control, Limits, Robot

KINK_FACTOR, KINK_SPEED = 1.3, 0.08
"""A change of velocity from step to step beyond this factor of what the wheels make, and this speed, is a contact."""


def sample_reference(
    times: np.ndarray, path: np.ndarray, now: float, look_ahead: float
) -> tuple[np.ndarray, np.ndarray]:
    """Position (2,) now and velocity (2,) look_ahead later; at rest at the end once the time is past.

    Args:
        times: (n,) strictly rising [s]; path: (n, 2) [m].
    """
    position = np.array([np.interp(now, times, path[:, a]) for a in range(2)])
    if now > times[-1]:
        return position, np.zeros(2)
    i = int(np.clip(np.searchsorted(times, now + look_ahead) - 1, 0, len(times) - 2))
    # central differences around the sample keep the velocity continuous at 20 Hz
    a, b = max(i - 1, 0), min(i + 2, len(times) - 1)
    return position, (path[b] - path[a]) / (times[b] - times[a])


@njit
def rollout_feed_forward(times: np.ndarray, path: np.ndarray, now: float, period: float, lag: float,
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


def saturate(velocity: np.ndarray, max_speed: float) -> np.ndarray:
    """The velocity (2,), shortened to max_speed with its direction kept."""
    speed = math.hypot(velocity[0], velocity[1])
    return velocity if speed <= max_speed else velocity * (max_speed / speed)


def pid(error: np.ndarray, feed_forward: np.ndarray, velocity_error: np.ndarray, integral: np.ndarray, period: float,
        control: Control, max_speed: float) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """World-frame velocity command (2,) [m/s] and the next integral (2,) [m/s].

    Anti-windup: the integral is limited, and does not grow while the command is saturated.
    """
    grown = saturate(integral + control.k_i * error * period, control.integral_limit)
    wanted = feed_forward + control.k_p * error + control.k_d * velocity_error + grown
    command = saturate(wanted, max_speed)
    return command, grown if command is wanted else integral


def to_body(velocity: np.ndarray, yaw: float) -> np.ndarray:
    """A world-frame velocity (2,) in the body frame of a robot with that yaw."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * velocity[0] + s * velocity[1], -s * velocity[0] + c * velocity[1]])


def hold_heading(yaw: float, held: float, control: Control) -> float:
    """Yaw rate that leads back to the held heading the short way [rad/s]."""
    error = math.remainder(held - yaw, 2 * math.pi)
    return float(np.clip(control.k_yaw * error, -control.max_yaw_rate, control.max_yaw_rate))


def clip_command(
    velocity: np.ndarray, yaw_rate: float, robot: Robot, limits: Limits
) -> tuple[np.ndarray, float] | None:
    """What a robot makes of a command: cut to its limits; None (refused) beyond excess_speed times them; NaN too."""
    if not (np.isfinite(velocity).all() and math.isfinite(yaw_rate)):
        return None
    too_fast = math.hypot(velocity[0], velocity[1]) > limits.excess_speed * robot.max_speed
    if too_fast or abs(yaw_rate) > limits.excess_speed * robot.max_yaw_rate:
        return None
    turn = min(max(yaw_rate, -robot.max_yaw_rate), robot.max_yaw_rate)
    return saturate(np.asarray(velocity, dtype=float), robot.max_speed), turn
