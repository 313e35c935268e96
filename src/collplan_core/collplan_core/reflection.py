"""The rebound of the disc from a boundary. Paper: II-B3, Garwin-type reflection."""

import numpy as np

from collplan_core.jit import njit


@njit
def reflect(vx: float, vy: float, nx: float, ny: float, restitution: float, retention: float) -> tuple[float, float]:
    """Velocity after a rebound, -e v_n n + k_t v_t [m/s]; even in the unit normal n, so that its sign is irrelevant."""
    vn = vx * nx + vy * ny
    tx, ty = vx - vn * nx, vy - vn * ny
    return retention * tx - restitution * vn * nx, retention * ty - restitution * vn * ny


def rebound(velocity: np.ndarray, normal: np.ndarray, restitution: float, tangential_retention: float) -> np.ndarray:
    """Velocity (2,) right after the contact [m/s].

    Args:
        velocity: (2,) before it [m/s].
        normal: (2,) unit normal of the boundary, either sign.
        restitution: share of the normal speed that comes back, in [0, 1].
        tangential_retention: share of the tangential speed that is kept, in [0, 1].
    """
    return np.array(reflect(velocity[0], velocity[1], normal[0], normal[1], restitution, tangential_retention))
