"""The robot's velocity law dv/dt = sat((u - v) / lag), solved: ahead for the velocity, back for the command."""

import math
from typing import NamedTuple

from collplan_core.jit import njit
from collplan_core.parameters import Robot

SHORTEST_LAG = 1e-3
"""A velocity loop without any lag is taken for this one [s]."""


class VelocityLaw(NamedTuple):
    """How the wheels follow a command: at full acceleration, then as a first-order lag.

    Attributes:
        max_acceleration: [m/s^2]; lag: [s].
        step: a duration that is asked for again and again [s].
        step_decay: share of a small difference to the command that is left after it.
    """

    max_acceleration: float
    lag: float
    step: float
    step_decay: float


def velocity_law(robot: Robot, step: float = 0.0) -> VelocityLaw:
    """The law of a robot, quick for durations of one step [s]."""
    lag = max(robot.velocity_lag, SHORTEST_LAG)
    return VelocityLaw(robot.max_acceleration, lag, step, math.exp(-step / lag))


@njit
def velocity_after(
    law: VelocityLaw, vx: float, vy: float, ux: float, uy: float, duration: float
) -> tuple[float, float]:
    """Velocity after `duration` [s] under command u, from velocity v [m/s]."""
    decay = law.step_decay if duration == law.step else math.exp(-duration / law.lag)
    return _velocity(law, vx, vy, ux, uy, duration, decay)


@njit
def velocity_after_step(law: VelocityLaw, vx: float, vy: float, ux: float, uy: float) -> tuple[float, float]:
    """Velocity after the law's step under command u, from velocity v [m/s]."""
    return _velocity(law, vx, vy, ux, uy, law.step, law.step_decay)


@njit
def _velocity(
    law: VelocityLaw, vx: float, vy: float, ux: float, uy: float, duration: float, decay: float
) -> tuple[float, float]:
    """Velocity after a duration that leaves `decay` of a small difference to the command."""
    dx, dy = ux - vx, uy - vy
    gap2 = dx * dx + dy * dy
    linear = law.max_acceleration * law.lag
    if gap2 <= linear * linear:
        share = 1.0 - decay
    else:
        gap = math.sqrt(gap2)
        saturated = (gap - linear) / law.max_acceleration
        if saturated >= duration:
            share = law.max_acceleration * duration / gap
        else:
            share = 1.0 - linear * math.exp(-(duration - saturated) / law.lag) / gap
    return vx + share * dx, vy + share * dy


@njit
def command_lead(law: VelocityLaw, change: float, duration: float) -> float:
    """How far ahead of the velocity a command must be, for that to change by `change` in a duration [m/s]."""
    linear, share = law.max_acceleration * law.lag, 1.0 - math.exp(-duration / law.lag)
    if change <= linear * share:
        return change / share
    # at full acceleration first: for how long has no closed form
    low, high = 0.0, duration
    for _ in range(20):
        middle = 0.5 * (low + high)
        if law.max_acceleration * middle + linear * (1.0 - math.exp(-(duration - middle) / law.lag)) < change:
            low = middle
        else:
            high = middle
    return linear + law.max_acceleration * high
