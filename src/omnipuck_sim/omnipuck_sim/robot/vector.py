"""Vectors of the plane as pairs: at 800 steps a second, arrays of two numbers cost more than the physics."""

Vector = tuple[float, float]
