"""The drive, motors that lead the wheels to a commanded velocity and traction between wheels and body, and free flight.

The wheels' reflected mass has a velocity of its own: a hit changes the body's alone, and traction then pulls the two
together. Written apart from the planner's model of the same law: this is the truth that the model is tested against.
Compiled, as at 800 steps a second calls cost more than what they compute; in one file, as numba's cache of a file does
not notice changes of another one in this package.
"""

from collections.abc import Iterable
from math import cos, exp, sin, sqrt
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Robot, Simulation
from collplan_core.plane import nearest_on_segment
from omnipuck_sim.robot.inertia import true_inertia
from omnipuck_sim.robot.walls import Edge, Pole

GRAVITY = 9.81
"""[m/s^2]"""
FLOOR_FRICTION = 0.8
"""Friction of wheels and floor (assumed)."""
MAX_YAW_ACCELERATION = 20.0
"""Largest yaw acceleration that the wheels make (assumed) [rad/s^2]."""
CLEAR = 1e-6
"""A disc nearer to a surface than this may touch it [m]."""
X, Y, VX, VY, YAW, SPIN, WHEELS_X, WHEELS_Y = range(8)
"""Columns of a motion (8,): position [m], velocity [m/s, world frame], yaw [rad], yaw rate [rad/s], and the velocity
at which the wheels roll [m/s, world frame]."""


class DriveLaw(NamedTuple):
    """dv/dt = (u - v) / lag of the wheels' velocity, at most max_acceleration, both of the true mass."""

    rate: float  # steps a second [Hz]
    mass: float  # of the body [kg]
    moment: float  # inertia of the body [kg m^2]
    wheel_mass: float  # reflected mass of the wheels [kg]
    share: float  # of the difference from the commanded velocity that the motors remove in a step
    largest_change: float  # in a step [m/s]
    largest_spin_change: float  # in a step [rad/s]
    traction: float  # largest impulse on the body in a step [N s]


def drive_law(robot: Robot, simulation: Simulation) -> DriveLaw:
    """The law of a robot for steps of simulator.physics_rate."""
    (mass, moment), step = true_inertia(robot, simulation), 1.0 / simulation.physics_rate
    lag = robot.velocity_lag * simulation.mass_ratio
    # the exact share of a first-order lag, so that a lag shorter than the step stays stable
    share = 1.0 - exp(-step / lag) if lag > 0.0 else 1.0
    acceleration = robot.max_acceleration * simulation.acceleration_ratio / simulation.mass_ratio
    return DriveLaw(
        rate=float(simulation.physics_rate),
        mass=mass,
        moment=moment,
        wheel_mass=simulation.wheel_mass,
        share=share,
        largest_change=acceleration * step,
        largest_spin_change=MAX_YAW_ACCELERATION * step,
        traction=FLOOR_FRICTION * mass * GRAVITY * step,
    )


def outline_of(pieces: Iterable[Edge | Pole], radius: float) -> tuple[float, np.ndarray, np.ndarray]:
    """Returns the outline that a disc may touch: radius, edges (n, 4) x, y to x, y, poles (m, 3) x, y, radius [m]."""
    pieces = list(pieces)
    edges = np.array([(*piece.a, *piece.b) for piece in pieces if isinstance(piece, Edge)])
    poles = np.array([(*piece.centre, piece.radius) for piece in pieces if isinstance(piece, Pole)])
    return radius, edges.reshape(-1, 4), poles.reshape(-1, 3)


class Aim(NamedTuple):
    """Aim of the motors: velocity x, y [m/s, body frame], yaw rate [rad/s], and an error of the velocity, world frame.

    Without `drives` the wheels are off the floor: nothing but impacts changes the velocity.
    """

    x: float = 0.0
    y: float = 0.0
    yaw_rate: float = 0.0
    error_x: float = 0.0
    error_y: float = 0.0
    drives: bool = True


@njit
def push(law: DriveLaw, motion: np.ndarray, aim: Aim) -> tuple[float, float, float]:
    """Force [N, world frame] and torque [N m] of the wheels in the next step; their own velocity changes in place."""
    if not aim.drives:
        return 0.0, 0.0, 0.0
    vx, vy, yaw, spin = motion[VX], motion[VY], motion[YAW], motion[SPIN]
    turned = min(max(law.share * (aim.yaw_rate - spin), -law.largest_spin_change), law.largest_spin_change)
    wanted_x, wanted_y = aim.x, aim.y
    # without noise where the command is zero
    if wanted_x != 0.0 or wanted_y != 0.0:
        c, s = cos(yaw), sin(yaw)
        wanted_x, wanted_y = c * aim.x - s * aim.y + aim.error_x, s * aim.x + c * aim.y + aim.error_y
    wheels_x, wheels_y = (motion[WHEELS_X], motion[WHEELS_Y]) if law.wheel_mass > 0.0 else (vx, vy)
    # what the motors change of the common velocity
    pushed_x, pushed_y = law.share * (wanted_x - wheels_x), law.share * (wanted_y - wheels_y)
    change = _length(pushed_x, pushed_y)
    if change > law.largest_change:
        pushed_x, pushed_y = pushed_x * law.largest_change / change, pushed_y * law.largest_change / change
    # what would bring body and wheels to one velocity within the step
    total = law.mass + law.wheel_mass
    wheel_share = law.wheel_mass / total
    impulse_x = law.mass * (pushed_x + wheel_share * (wheels_x - vx))
    impulse_y = law.mass * (pushed_y + wheel_share * (wheels_y - vy))
    impulse = _length(impulse_x, impulse_y)
    if impulse > law.traction:
        impulse_x, impulse_y = impulse_x * law.traction / impulse, impulse_y * law.traction / impulse
    if law.wheel_mass > 0.0:
        motion[WHEELS_X] = wheels_x + (total * pushed_x - impulse_x) / law.wheel_mass
        motion[WHEELS_Y] = wheels_y + (total * pushed_y - impulse_y) / law.wheel_mass
    step = 1.0 / law.rate
    return impulse_x / step, impulse_y / step, law.moment * turned * law.rate


@njit
def _length(x: float, y: float) -> float:
    """sqrt(x^2 + y^2), rounded as math.hypot does: libm's has other last bits, by platform too."""
    squares, lost = _square(x)
    more, more_lost = _square(y)
    h = sqrt(squares + more)
    if h == 0.0:
        return 0.0
    again, again_lost = _square(h)
    big, small = max(squares, more), min(squares, more)
    return h + ((big - again) + small + (lost + more_lost - again_lost)) / (2.0 * h)


@njit
def _square(x: float) -> tuple[float, float]:
    """x^2 and what its rounding lost (Dekker 1971)."""
    split = 134217729.0 * x
    high = split - (split - x)
    low, square = x - high, x * x
    return square, ((high * high - square) + 2.0 * high * low) + low * low


@njit
def _is_clear(x: float, y: float, outline: tuple) -> bool:
    reach, edges, poles = outline[0] + CLEAR, outline[1], outline[2]
    for pole_x, pole_y, radius in poles:
        if (pole_x - x) ** 2 + (pole_y - y) ** 2 <= (reach + radius) ** 2:
            return False
    for ax, ay, bx, by in edges:
        near_x, near_y = nearest_on_segment(ax, ay, bx, by, x, y)
        if (near_x - x) ** 2 + (near_y - y) ** 2 <= reach * reach:
            return False
    return True


@njit
def flown(motion: np.ndarray, law_fields: tuple, aim_fields: tuple, outline: tuple, most: int) -> int:
    """Moves on in free flight, by steps as pymunk makes them; returns how many of at most `most` do not end in a touch.

    The motion (8,) is changed in place. Law and aim are a DriveLaw and an Aim as plain tuples, which cost a tenth to
    hand over; the outline is a result of `outline_of`.
    """
    law, aim = DriveLaw(*law_fields), Aim(*aim_fields)
    step = 1.0 / law.rate
    for k in range(most):
        x, y = motion[X] + motion[VX] * step, motion[Y] + motion[VY] * step
        if not _is_clear(x, y, outline):
            return k
        force_x, force_y, torque = push(law, motion, aim)
        motion[X], motion[Y] = x, y
        motion[YAW] += motion[SPIN] * step
        motion[VX] += force_x * (1.0 / law.mass) * step
        motion[VY] += force_y * (1.0 / law.mass) * step
        motion[SPIN] += torque * (1.0 / law.moment) * step
    return most
