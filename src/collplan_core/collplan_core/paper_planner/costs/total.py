"""The objective w_p J_pos + w_r J_risk + w_v J_vel of all candidates, and the least of it. Paper: eq. (1)."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.paper_planner.costs.model import CostModel


@njit
def normalize(values: np.ndarray) -> np.ndarray:
    """(n,) mapped onto [0, 1]; all 0 where there is no spread."""
    low, high = np.inf, -np.inf
    for value in values:
        low, high = min(low, value), max(high, value)
    if not high - low > 1e-12:
        return np.zeros(len(values))
    return (values - low) / (high - low)


TERMS = ("total", "position", "risk", "collision_risk", "gap_risk", "approach_risk", "velocity", "rebound_reward")
TOTAL, POSITION, RISK, COLLISION_RISK, GAP_RISK, APPROACH_RISK, VELOCITY, REBOUND_REWARD = range(len(TERMS))


@njit
def weighted_terms(
    position_of: np.ndarray,
    position_cost: np.ndarray,
    gap_risk: np.ndarray,
    approach_risk: np.ndarray,
    collision_risk: np.ndarray,
    reward: np.ndarray,
    velocity_cost: np.ndarray,
    model: CostModel,
) -> np.ndarray:
    """(c, len(TERMS)) every term of every candidate, their weighted sum first. Paper: eq. (1); Alg. 2, line 12.

    Line 12 is J_risk = J_risk,g + J_risk,h; a boundary that the approach crosses adds to it. `position_of` (c,) is the
    position of each candidate. The position's cost, J_pos, and the risks of gap and approach (p,) depend on the
    position alone; the collision's risk, reward and velocity's cost (c,) are J_risk,h, R_ref and J_vel.
    """
    terms = np.empty((len(position_of), len(TERMS)))
    for i in range(len(position_of)):
        p = position_of[i]
        terms[i, POSITION] = position_cost[p]
        terms[i, COLLISION_RISK], terms[i, GAP_RISK], terms[i, APPROACH_RISK] = (
            collision_risk[i],
            gap_risk[p],
            approach_risk[p],
        )
        terms[i, RISK] = collision_risk[i] + gap_risk[p] + approach_risk[p]
        terms[i, REBOUND_REWARD] = reward[i]
        terms[i, VELOCITY] = velocity_cost[i]
        terms[i, TOTAL] = (
            model.position_weight * terms[i, POSITION]
            + model.risk_weight * terms[i, RISK]
            + model.velocity_weight * terms[i, VELOCITY]
        )
    return terms


TIE_BREAK = 1e-3
"""Cost by which v_max along the approach wins over rest."""


@njit
def least_forward(
    total: np.ndarray, points: np.ndarray, velocities: np.ndarray, current: np.ndarray, max_speed: float
) -> int:
    """The candidate (c,) of least cost less TIE_BREAK times the share of v_max along the approach.

    The velocity along the approach decides also between costs closer than that. Points and velocities (c, 2) are p_s
    [m] and v_s [m/s], `current` (2,) is p_cur [m], `max_speed` v_max [m/s].
    """
    best, chosen = math.inf, -1
    for i in range(len(total)):
        dx, dy = points[i, 0] - current[0], points[i, 1] - current[1]
        along = (velocities[i, 0] * dx + velocities[i, 1] * dy) / max(math.hypot(dx, dy), 1e-12)
        cost = total[i] - TIE_BREAK * along / max_speed
        if cost < best:
            best, chosen = cost, i
    return chosen


def least_first(
    total: np.ndarray, points: np.ndarray, velocities: np.ndarray, current: np.ndarray, max_speed: float
) -> int:
    """The first candidate of least cost (c,)."""
    return int(np.argmin(total))


LEAST_WHERE_SPEED_IS_FREE = {"forward": least_forward, "first": least_first}
"""The choice of the least cost where w_v = 0, by planner.tie_rule."""
