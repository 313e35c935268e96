"""J_pos: the way to the goal through a candidate, and the penalty on turning. Paper: Alg. 1."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.paper_planner.costs.total import normalize


@njit
def angle_between(ax: float, ay: float, bx: float, by: float) -> float:
    """Angle between two vectors in [0, pi]; 0 where one has no direction."""
    if math.hypot(ax, ay) < 1e-9 or math.hypot(bx, by) < 1e-9:
        return 0.0
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))


def straight_on(
    previous: np.ndarray, aim: np.ndarray, position: np.ndarray, center: np.ndarray, printed: bool
) -> np.ndarray:
    """(2,) direction that the angle of Alg. 1 counts from: that in which the previous plan aimed.

    It was made at `previous` (2,), p_pre [m], and aimed at `aim` (2,), its p_s [m]; NaN without one, and the direction
    then too. The position (2,) is p_cur [m], the centre (2,) that of F [m]. `printed`: from p_cur back to p_pre, so
    that the angle is the interior one, as printed.
    """
    if printed and not math.isnan(aim[0]):
        return (previous - center) - (position - center)
    return aim if printed else aim - previous


@njit
def _path_lengths_and_turns(
    positions: np.ndarray, current: np.ndarray, goal: np.ndarray, straight_on: np.ndarray, turn_threshold: float
) -> tuple[np.ndarray, np.ndarray]:
    """Length |p_cur p_s| + |p_s p_goal| of each position (p,) [m], and whether it takes too large a turn (p,)."""
    # Paper: Alg. 1, lines 1 to 4.
    n = len(positions)
    length = np.empty(n)
    turns = np.zeros(n, np.bool_)
    for i in range(n):
        dx, dy = positions[i, 0] - current[0], positions[i, 1] - current[1]
        length[i] = math.hypot(dx, dy) + math.hypot(goal[0] - positions[i, 0], goal[1] - positions[i, 1])
        turns[i] = angle_between(straight_on[0], straight_on[1], dx, dy) >= turn_threshold
    return length, turns


@njit
def position_costs(
    positions: np.ndarray,
    current: np.ndarray,
    goal: np.ndarray,
    straight_on: np.ndarray,
    travelled: float,
    turn_threshold: float,
    turn_penalty: float,
    printed: bool,
) -> np.ndarray:
    """J_pos (p,) with the lengths normalised before the turns are penalised. Paper: Alg. 1.

    Args:
        positions: (p, 2) candidate positions p_s [m]; current, goal: (2,) p_cur and p_goal [m].
        straight_on: (2,) direction that turns count from; NaN without a previous plan: then none is penalised.
        travelled: |p_ini p_pre| + |p_pre p_cur| [m], equal for all and so without effect if not as printed.
        turn_threshold, turn_penalty: theta_thres [rad] and f_a.
        printed: as Alg. 1 is printed, the turns are penalised before the lengths are normalised.
    """
    length, turns = _path_lengths_and_turns(positions, current, goal, straight_on, turn_threshold)
    if printed:
        return normalize(np.where(turns, turn_penalty, 1.0) * (travelled + length))
    normalised = normalize(length)
    return np.where(turns, turn_penalty * (1.0 + normalised) - 1.0, normalised)
