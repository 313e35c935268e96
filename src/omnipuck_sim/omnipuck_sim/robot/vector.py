"""Vectors of the plane as pairs: at 400 steps a second, arrays of two numbers cost more than the physics."""

from math import cos, sin

Vector = tuple[float, float]


def rotated(v: Vector, angle: float) -> Vector:
    """v turned by an angle [rad]."""
    c, s = cos(angle), sin(angle)
    return c * v[0] - s * v[1], s * v[0] + c * v[1]
