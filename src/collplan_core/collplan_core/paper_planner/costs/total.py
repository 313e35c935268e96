"""The objective w_p J_pos + w_r J_risk + w_v J_vel over all candidates. Paper: eq. (1)."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.paper_planner.costs.normalize import normalize
from collplan_core.paper_planner.costs.risk import collision_rate
from collplan_core.paper_planner.costs.velocity import rebound_reward, velocity_cost

TERMS = ("total", "position", "risk", "collision_risk", "gap_risk", "approach_risk", "velocity", "rebound_reward")
TOTAL, POSITION, RISK, COLLISION_RISK, GAP_RISK, APPROACH_RISK, VELOCITY, REBOUND_REWARD = range(len(TERMS))


@njit
def evaluate(positions: np.ndarray, at: np.ndarray, velocity: np.ndarray, j_pos: np.ndarray, gap: np.ndarray,
             approach: np.ndarray, current: np.ndarray, goal: np.ndarray, ends: np.ndarray, predicted: np.ndarray,
             weights: np.ndarray, speed_floor: float, time_floor: float, restitution: float, retention: float,
             horizon: float, penalty: float, unit_vector: bool, with_reward: bool,
             with_factor: bool) -> np.ndarray:  # fmt: skip
    """(c, len(TERMS)) every term of every candidate. Points relative to the centre of F.

    Args:
        positions: (p, 2); j_pos, gap, approach: (p,) what depends on the position alone.
        at: (c,) position of each candidate; velocity: (c, 2) [m/s].
        current, goal: (2,) [m]; ends: (n, 2) border of F; predicted: (e, 4) set E.
        weights: (3,) w_p, w_r, w_v.
    """
    c = len(at)
    terms = np.zeros((c, 8))
    rate, distance, which = np.empty(c), np.empty(c), np.empty(c, np.int64)
    for i in range(c):
        x, y = positions[at[i]]
        rate[i], distance[i], which[i] = collision_rate(
            x, y, velocity[i, 0], velocity[i, 1], predicted, speed_floor, time_floor
        )
    hit_risk = normalize(rate)
    gx, gy = goal[0] - current[0], goal[1] - current[1]
    far = max(math.hypot(gx, gy), 1e-12)
    vx, vy = (gx / far, gy / far) if unit_vector else (gx, gy)
    for i in range(c):
        p = at[i]
        reward = 0.0
        if with_reward and which[i] >= 0:
            reward = rebound_reward(
                positions[p, 0], positions[p, 1], velocity[i, 0], velocity[i, 1], distance[i], predicted[which[i], 2:],
                gx / far, gy / far, ends, restitution, retention, horizon, penalty,
            )  # fmt: skip
        terms[i, POSITION] = j_pos[p]
        terms[i, COLLISION_RISK], terms[i, GAP_RISK], terms[i, APPROACH_RISK] = hit_risk[i], gap[p], approach[p]
        terms[i, RISK] = hit_risk[i] + gap[p] + approach[p]
        terms[i, REBOUND_REWARD] = reward
        if with_factor:
            terms[i, VELOCITY] = velocity_cost(velocity[i, 0], velocity[i, 1], vx, vy, hit_risk[i], reward)
        else:
            terms[i, VELOCITY] = -(velocity[i, 0] * vx + velocity[i, 1] * vy) - reward * hit_risk[i]
        terms[i, TOTAL] = (
            weights[0] * terms[i, POSITION] + weights[1] * terms[i, RISK] + weights[2] * terms[i, VELOCITY]
        )
    return terms


@njit
def choose(terms: np.ndarray, positions: np.ndarray, at: np.ndarray, velocity: np.ndarray, current: np.ndarray,
           max_speed: float, forward: float) -> int:  # fmt: skip
    """The candidate of least cost; equal ones are told apart by forward times the speed along the approach."""
    best, which = math.inf, -1
    for i in range(len(terms)):
        dx, dy = positions[at[i], 0] - current[0], positions[at[i], 1] - current[1]
        along = (velocity[i, 0] * dx + velocity[i, 1] * dy) / max(math.hypot(dx, dy), 1e-12)
        cost = terms[i, TOTAL] - forward * along / max_speed
        if cost < best:
            best, which = cost, i
    return which
