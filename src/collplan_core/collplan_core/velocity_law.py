"""The robot's velocity law dv/dt = sat((u - v) / lag), solved: ahead for the velocity, back for the command."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Robot

SHORTEST_LAG = 1e-3
"""Smallest lag of the velocity loop; a smaller one counts as this [s]."""


class VelocityLaw(NamedTuple):
    """Law by which the wheels follow a command: at full acceleration, then as a first-order lag."""

    max_acceleration: float  # [m/s^2]
    lag: float  # [s]
    step: float  # a duration that is used often [s]
    step_decay: float  # share of a small difference to the command that is left after the step


class Course(NamedTuple):
    """A velocity on its way to a command that holds: along a straight line, so that one number gives its place."""

    ux: float  # ux, uy: the command [m/s]
    uy: float
    ex: float  # ex, ey: unit direction in which the velocity is off the command
    ey: float
    gap: float  # distance of the velocity from the command [m/s]


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
    course = course_to(vx, vy, ux, uy)
    gap = _gap_after(law, course.gap, duration, decay)
    return ux + gap * course.ex, uy + gap * course.ey


@njit
def rolled(law: VelocityLaw, motion: np.ndarray, wanted: np.ndarray, durations: np.ndarray) -> np.ndarray:
    """Positions and velocities (n + 1, 4) from a motion (4,) on under commands (n, 2), each for a duration (n,) [s]."""
    rows = np.empty((len(wanted) + 1, 4))
    rows[0] = motion
    for k in range(len(wanted)):
        x, y, vx, vy = rows[k]
        wx, wy = velocity_after(law, vx, vy, wanted[k, 0], wanted[k, 1], durations[k])
        rows[k + 1, 0], rows[k + 1, 1] = x + 0.5 * (vx + wx) * durations[k], y + 0.5 * (vy + wy) * durations[k]
        rows[k + 1, 2], rows[k + 1, 3] = wx, wy
    return rows


@njit
def course_to(vx: float, vy: float, ux: float, uy: float) -> Course:
    """The course from velocity v to command u [m/s]."""
    dx, dy = vx - ux, vy - uy
    gap = math.sqrt(dx * dx + dy * dy)
    return Course(ux, uy, dx / gap, dy / gap, gap) if gap > 0.0 else Course(ux, uy, 0.0, 0.0, 0.0)


@njit
def course_after_step(law: VelocityLaw, course: Course) -> Course:
    """The course after the law's step; its velocity is u + gap e."""
    gap = _gap_after(law, course.gap, law.step, law.step_decay)
    return Course(course.ux, course.uy, course.ex, course.ey, gap)


@njit
def _gap_after(law: VelocityLaw, gap: float, duration: float, decay: float) -> float:
    """Returns how far the velocity is off the command [m/s] after a duration that leaves `decay` of a small gap."""
    linear, fall = law.max_acceleration * law.lag, law.max_acceleration * duration
    if gap <= linear:
        return gap * decay
    if gap >= linear + fall:
        return gap - fall
    return linear * math.exp(-(duration - (gap - linear) / law.max_acceleration) / law.lag)


@njit
def command_lead(law: VelocityLaw, change: float, duration: float) -> float:
    """Returns how far a command must lead the velocity for that to change by `change` in a duration [m/s]."""
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
