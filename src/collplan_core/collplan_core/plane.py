"""Geometry of the plane that every part needs: rotation, and the nearest point of a segment."""

import math

import numpy as np

from collplan_core.jit import jitable, njit


@jitable
def rotate(x: float, y: float, angle: float) -> tuple[float, float]:
    """The vector (x, y) turned by an angle [rad], counter-clockwise."""
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def rotate_rows(vectors: np.ndarray, angles: np.ndarray | float) -> np.ndarray:
    """(n, 2) vectors, each turned by its own angle (n,), or all by the same one [rad]."""
    c, s = np.cos(angles), np.sin(angles)
    x, y = vectors.T
    return np.column_stack([c * x - s * y, s * x + c * y])


@njit
def nearest_on_segment(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> tuple[float, float]:
    """The point of the segment from a to b that is nearest to (x, y); a itself where both are the same point."""
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    along = 0.0 if length2 < 1e-24 else min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / length2))
    return ax + along * dx, ay + along * dy
