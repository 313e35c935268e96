"""J_vel: value of the velocity at the candidate, straight on and after a rebound. Paper: eq. (2) and (3)."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import inside
from collplan_core.paper_planner.costs.model import CostModel
from collplan_core.reflection import reflect


@njit
def unit_vector(to_goal: np.ndarray) -> np.ndarray:
    """(2,) the direction of p_goal - p_cur, (2,)."""
    return to_goal / max(math.hypot(to_goal[0], to_goal[1]), 1e-12)


@njit
def rebound_reward(
    contact_x: float,
    contact_y: float,
    vx: float,
    vy: float,
    tangent: np.ndarray,
    border: np.ndarray,
    goal_direction: np.ndarray,
    model: CostModel,
) -> float:
    """R_ref = <v_ref, unit_goal>, or the penalty where the rebound ends in known free space. Paper: eq. (2).

    The contact is p_p, the velocity v_s [m/s]. The tangent (2,) is e_p of the predicted boundary, the goal's direction
    (2,) a unit vector too. The contact and the border points (n, 2) of F are relative to its centre [m].
    """
    # n_p = Rot(e_p, pi/2); its sign has no effect
    rx, ry, _ = reflect(vx, vy, 0.0, -tangent[1], tangent[0], model.ring)
    if inside(border, contact_x + rx * model.rebound_horizon, contact_y + ry * model.rebound_horizon):
        return model.rebound_penalty
    return rx * goal_direction[0] + ry * goal_direction[1]


@njit
def rebound_rewards(
    points: np.ndarray,
    velocities: np.ndarray,
    distance: np.ndarray,
    line: np.ndarray,
    predicted: np.ndarray,
    border: np.ndarray,
    to_goal: np.ndarray,
    model: CostModel,
) -> np.ndarray:
    """R_ref of each candidate (c,), 0 where it meets no predicted boundary. Paper: eq. (2).

    Args:
        points, velocities: (c, 2) p_s [m] and v_s [m/s].
        distance, line: (c,) d_p [m] and the index of the half line met, -1 for none.
        predicted: (e, 4) set E; border: (n, 2) border points of F; both, and the points, relative to the centre of F.
        to_goal: (2,) p_goal - p_cur [m].
    """
    rewards, goal_direction = np.zeros(len(points)), unit_vector(to_goal)
    for i in range(len(points)):
        if line[i] < 0:
            continue
        vx, vy = velocities[i]
        speed = math.hypot(vx, vy)
        x, y = points[i, 0] + vx / speed * distance[i], points[i, 1] + vy / speed * distance[i]
        rewards[i] = rebound_reward(x, y, vx, vy, predicted[line[i], 2:], border, goal_direction, model)
    return rewards


@njit
def velocity_costs(
    velocities: np.ndarray, goal_vector: np.ndarray, collision_risk: np.ndarray, reward: np.ndarray, has_factor: bool
) -> np.ndarray:
    """J_vel = -<v_s, goal vector> (1 - J_risk,h) - R_ref J_risk,h of each candidate (c,). Paper: eq. (3).

    The velocities (c, 2) are v_s [m/s], the goal vector (2,) is in [m] or without unit; risk and reward (c,) are
    J_risk,h and R_ref. `has_factor`: whether eq. (3) has its factor (1 - J_risk,h).
    """
    costs = np.empty(len(velocities))
    for i in range(len(velocities)):
        toward = velocities[i, 0] * goal_vector[0] + velocities[i, 1] * goal_vector[1]
        share = 1.0 - collision_risk[i] if has_factor else 1.0
        costs[i] = -toward * share - reward[i] * collision_risk[i]
    return costs
