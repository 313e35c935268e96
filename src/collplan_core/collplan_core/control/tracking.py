"""Following a timed reference: PID, saturation that keeps the direction, body frame. Paper: III-B."""

import math

import numpy as np

from collplan_core.parameters import Control, Limits, Robot
from collplan_core.plane import rotate

SLOW = 0.05
"""A reference slower than this has no direction [m/s]."""


def sample_reference(times: np.ndarray, path: np.ndarray, now: float) -> tuple[np.ndarray, np.ndarray]:
    """Position (2,) and velocity (2,) of a timed path now; at rest at the end once the time is past.

    Args:
        times: (n,) strictly rising [s]; path: (n, 2) [m].
    """
    position = np.array([np.interp(now, times, path[:, axis]) for axis in range(2)])
    if now > times[-1]:
        return position, np.zeros(2)
    i = min(max(int(times.searchsorted(now)) - 1, 0), len(times) - 2)
    # central differences around the sample keep the velocity continuous at 20 Hz
    before, after = max(i - 1, 0), min(i + 2, len(times) - 1)
    return position, (path[after] - path[before]) / (times[after] - times[before])


def saturate(velocity: np.ndarray, max_speed: float) -> np.ndarray:
    """The velocity (2,), shortened to max_speed with its direction kept."""
    speed = math.hypot(velocity[0], velocity[1])
    return velocity if speed <= max_speed else velocity * (max_speed / speed)


def _without(growth: np.ndarray, cut_off: np.ndarray) -> np.ndarray:
    """A growth (2,) without its part along what is cut off (2,)."""
    along = float(growth @ cut_off)
    return growth - along / float(cut_off @ cut_off) * cut_off if along > 0.0 else growth


def pid(
    error: np.ndarray,
    feed_forward: np.ndarray,
    reference_velocity: np.ndarray,
    velocity: np.ndarray,
    integral: np.ndarray,
    period: float,
    control: Control,
    robot: Robot,
) -> tuple[np.ndarray, np.ndarray]:
    """World-frame velocity command (2,) [m/s] and the next integral (2,) [m/s].

    What is late along the path is not integrated: mostly no push, but a reference that the wheels cannot keep up with.
    Anti-windup: the integral is limited, and does not grow along what is cut off the command by v_max, or off the
    acceleration that it asks for by the wheels.
    """
    speed2 = float(reference_velocity @ reference_velocity)
    aside = error - error @ reference_velocity / max(speed2, SLOW**2) * reference_velocity
    growth = control.k_i * aside * period
    wanted = feed_forward + control.k_p * error + control.k_d * (reference_velocity - velocity) + integral + growth
    command = saturate(wanted, robot.max_speed)
    lead = command - velocity
    growth = _without(growth, wanted - command)
    growth = _without(growth, lead - saturate(lead, robot.max_acceleration * robot.velocity_lag))
    return command, saturate(integral + growth, control.integral_limit)


def to_body(velocity: np.ndarray, yaw: float) -> np.ndarray:
    """A world-frame velocity (2,) in the body frame of a robot with that yaw."""
    return np.array(rotate(velocity[0], velocity[1], -yaw))


def hold_heading(yaw: float, held: float, control: Control) -> float:
    """Yaw rate that leads back to the held heading the short way [rad/s]."""
    error = math.remainder(held - yaw, 2 * math.pi)
    return min(max(control.k_yaw * error, -control.max_yaw_rate), control.max_yaw_rate)


def clip_command(
    velocity: np.ndarray, yaw_rate: float, robot: Robot, limits: Limits
) -> tuple[np.ndarray, float] | None:
    """A command cut to the robot's limits; None (refused) where it is not finite or beyond excess_speed times them."""
    if not (np.isfinite(velocity).all() and math.isfinite(yaw_rate)):
        return None
    too_fast = math.hypot(velocity[0], velocity[1]) > limits.excess_speed * robot.max_speed
    if too_fast or abs(yaw_rate) > limits.excess_speed * robot.max_yaw_rate:
        return None
    return cut_to_limits(velocity, yaw_rate, robot)


def cut_to_limits(velocity: np.ndarray, yaw_rate: float, robot: Robot) -> tuple[np.ndarray, float]:
    """Velocity (2,) [m/s] and yaw rate [rad/s], both finite, that the robot's limits leave of a command."""
    turn = min(max(yaw_rate, -robot.max_yaw_rate), robot.max_yaw_rate)
    return saturate(np.asarray(velocity, dtype=float), robot.max_speed), turn
