"""The velocities that may be commanded: a disc, or a square in the body frame where each axis is limited on its own.

Both are given by one number, the share of a direction. Where that is 1, as for the disc, it changes no bit.
"""

import math
from typing import NamedTuple

from collplan_core.jit import jitable
from collplan_core.parameters import Robot


class VelocityBounds(NamedTuple):
    """robot.max_speed and robot.velocity_shape, seen in one frame."""

    max_speed: float  # [m/s]
    fastest: float  # largest speed in any direction [m/s]
    is_box: bool  # whether max_speed limits each axis of the body frame, instead of the length
    cos: float  # cos, sin: of the robot's yaw in the frame
    sin: float


def velocity_bounds(robot: Robot, yaw: float = 0.0) -> VelocityBounds:
    """The bounds in a frame in which the robot has this yaw [rad]; by default its own."""
    return VelocityBounds(robot.max_speed, robot.fastest, robot.velocity_shape == "box", math.cos(yaw), math.sin(yaw))


@jitable
def share_along(bounds: VelocityBounds, x: float, y: float) -> float:
    """max_speed as a share of the largest speed along (x, y): 1, for a box down to 1 / sqrt 2 along its diagonals."""
    if not bounds.is_box:
        return 1.0
    larger = max(abs(bounds.cos * x + bounds.sin * y), abs(bounds.cos * y - bounds.sin * x))
    return larger / math.hypot(x, y) if larger > 0.0 else 1.0


@jitable
def fastest_along(bounds: VelocityBounds, x: float, y: float) -> float:
    """Largest speed along (x, y) [m/s]."""
    if not bounds.is_box:
        return bounds.max_speed
    return bounds.max_speed / share_along(bounds, x, y)


@jitable
def within(bounds: VelocityBounds, ux: float, uy: float) -> tuple[float, float]:
    """A velocity shortened to the bounds, its direction kept."""
    speed = math.sqrt(ux * ux + uy * uy)
    if speed <= bounds.max_speed:
        return ux, uy
    most = fastest_along(bounds, ux, uy)
    return (ux * most / speed, uy * most / speed) if speed > most else (ux, uy)


@jitable
def room_along(bounds: VelocityBounds, vx: float, vy: float, dx: float, dy: float) -> float:
    """Largest change of the velocity v along the unit direction d that stays within the bounds [m/s]."""
    if not bounds.is_box:
        along = vx * dx + vy * dy
        root = along * along + bounds.max_speed * bounds.max_speed - vx * vx - vy * vy
        return math.sqrt(root) - along if root > 0.0 else 0.0
    c, s, room = bounds.cos, bounds.sin, math.inf
    for v, d in ((c * vx + s * vy, c * dx + s * dy), (c * vy - s * vx, c * dy - s * dx)):
        if abs(d) > 1e-9:
            room = min(room, bounds.max_speed / abs(d) - v / d)
    return max(room, 0.0)
