"""The rebound of the disc from a boundary: restitution across it, Coulomb friction and spin along it. Paper: II-B3.

The paper simplifies to the model of R. L. Garwin, "Kinematics of an Ultraelastic Rough Ball", American Journal of
Physics 37 (1969), a disc that grips; here its rim slides where friction does not suffice to grip.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Settings

DIFFERENCE = 1e-6
"""Difference of velocity that a derivative is taken over [m/s]."""


class Ring(NamedTuple):
    """The reflection ring as the planner models it."""

    restitution: float  # e, share of the speed into the boundary that comes back
    friction: float  # mu, Coulomb friction of ring and boundary
    inertia_factor: float  # 1 / (1 + m r^2 / I), share of the slip of the rim that gripping takes from the velocity
    body_share: float = 1.0
    """m / (m + m_w), share of a change of velocity that is left once traction has pulled body and wheels together, some
    hundredths of a second later; a hit changes the velocity of the body alone."""


def believed_ring(settings: Settings) -> Ring:
    """The ring by the parameters."""
    robot = settings.robot
    body_share = robot.mass / (robot.mass + robot.wheel_mass)
    return Ring(settings.rebound.restitution, settings.rebound.friction, robot.inertia_factor, body_share)


@njit
def reflect(vx: float, vy: float, rim: float, nx: float, ny: float, ring: Ring) -> tuple[float, float, float]:
    """Velocity [m/s] and rim speed [m/s] after a rebound; even in the unit normal n, so that its sign is irrelevant.

    v_n' = -e v_n, and v_t changes by -sign(s) min(mu (1 + e) |v_n|, |s| / (1 + m r^2 / I)) where the rim slips by s,
    the velocity along the boundary of the point that touches it. `rim` is omega r, the speed of the rim by spin,
    counter-clockwise. Of the change of velocity `ring.body_share` is left.
    """
    vn = vx * nx + vy * ny
    if vn > 0.0:
        nx, ny, vn = -nx, -ny, -vn
    # along the boundary, to the left of the normal; the point touched lies against the normal
    tx, ty = -ny, nx
    slip = vx * tx + vy * ty - rim
    grip = min(-ring.friction * (1.0 + ring.restitution) * vn, abs(slip) * ring.inertia_factor)
    change = -math.copysign(grip, slip)
    bounce = -(1.0 + ring.restitution) * vn
    rim_change = -change * (1.0 / ring.inertia_factor - 1.0)
    dx, dy = bounce * nx + change * tx, bounce * ny + change * ty
    return vx + ring.body_share * dx, vy + ring.body_share * dy, rim + rim_change


@njit
def rebound_slope(vx: float, vy: float, nx: float, ny: float, ring: Ring) -> tuple[float, float, float, float]:
    """Derivative of the velocity after a rebound of a disc without spin by that before: xx, xy, yx, yy, xy of x by vy.

    A rebound is linear but for bends where gripping and sliding part, so that a difference is exact.
    """
    wx, wy, _ = reflect(vx, vy, 0.0, nx, ny, ring)
    ax, ay, _ = reflect(vx + DIFFERENCE, vy, 0.0, nx, ny, ring)
    bx, by, _ = reflect(vx, vy + DIFFERENCE, 0.0, nx, ny, ring)
    return (ax - wx) / DIFFERENCE, (bx - wx) / DIFFERENCE, (ay - wy) / DIFFERENCE, (by - wy) / DIFFERENCE


def rebound(velocity: np.ndarray, normal: np.ndarray, ring: Ring) -> np.ndarray:
    """Velocity (2,) right after the contact of a disc without spin [m/s].

    Args:
        velocity: (2,) before it [m/s].
        normal: (2,) unit normal of the boundary, either sign.
    """
    return np.array(reflect(velocity[0], velocity[1], 0.0, normal[0], normal[1], ring)[:2])
