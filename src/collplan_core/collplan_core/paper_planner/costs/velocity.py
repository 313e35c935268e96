"""J_vel: what the velocity at the candidate is worth, straight on and after a rebound. Paper: eq. (2) and (3)."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import inside
from collplan_core.reflection import reflect


@njit
def rebound_reward(px: float, py: float, vx: float, vy: float, distance: float, tangent: np.ndarray,
                   gx: float, gy: float, ends: np.ndarray, restitution: float, retention: float, horizon: float,
                   penalty: float) -> float:  # fmt: skip
    """R_ref = <v_ref, unit_goal>, or the penalty where the rebound ends in known free space. Paper: eq. (2).

    Args:
        px, py, vx, vy: candidate, relative to the centre of F [m], and its velocity [m/s].
        distance: d_p along the velocity [m].
        tangent: (2,) unit vector e_p of the predicted boundary.
        gx, gy: unit vector to the goal.
        horizon: time after the rebound at which p_ref is taken [s].
    """
    speed = math.hypot(vx, vy)
    # n_p = Rot(e_p, pi/2); its sign has no effect
    rx, ry = reflect(vx, vy, -tangent[1], tangent[0], restitution, retention)
    x, y = px + vx / speed * distance + rx * horizon, py + vy / speed * distance + ry * horizon
    if inside(ends, x, y):
        return penalty
    return rx * gx + ry * gy


@njit
def velocity_cost(vx: float, vy: float, gx: float, gy: float, collision_risk: float, reward: float) -> float:
    """J_vel = -<v_s, goal vector> (1 - J_risk,h) - R_ref J_risk,h. Paper: eq. (3)."""
    return -(vx * gx + vy * gy) * (1.0 - collision_risk) - reward * collision_risk
