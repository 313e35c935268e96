"""J_pos: the way to the goal through a candidate, and the penalty on turning. Paper: Alg. 1."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.paper_planner.costs.normalize import normalize


@njit
def angle_between(ax: float, ay: float, bx: float, by: float) -> float:
    """Angle between two vectors in [0, pi]; 0 where one has no direction."""
    if math.hypot(ax, ay) < 1e-9 or math.hypot(bx, by) < 1e-9:
        return 0.0
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))


@njit
def position_costs(positions: np.ndarray, current: np.ndarray, goal: np.ndarray, previous_aim: np.ndarray,
                   previous: np.ndarray, travelled: float, has_previous: bool, turn_threshold: float,
                   turn_penalty: float, interior_angle: bool, as_printed: bool) -> np.ndarray:  # fmt: skip
    """J_pos of each position.

    Args:
        positions: (p, 2) candidate positions p_s [m].
        current, goal: (2,) p_cur and p_goal [m].
        previous_aim: (2,) the previous plan's p_s minus the position it was made at [m].
        previous: (2,) the position the previous plan was made at, p_pre [m].
        travelled: |p_ini p_pre| + |p_pre p_cur| [m], equal for all and so without effect but in the printed form.
        has_previous: without a previous plan there is no penalty.
        turn_threshold, turn_penalty: theta_thres [rad] and f_a.
        interior_angle: the printed angle, at p_cur between p_pre and p_s, instead of the turn between two aims.
        as_printed: penalise before normalising, as Alg. 1 is printed.
    """
    n = len(positions)
    length = np.empty(n)
    penalised = np.zeros(n, np.bool_)
    for i in range(n):
        dx, dy = positions[i, 0] - current[0], positions[i, 1] - current[1]
        length[i] = math.hypot(dx, dy) + math.hypot(goal[0] - positions[i, 0], goal[1] - positions[i, 1])
        if interior_angle:
            turn = angle_between(previous[0] - current[0], previous[1] - current[1], dx, dy)
        else:
            turn = angle_between(previous_aim[0], previous_aim[1], dx, dy)
        penalised[i] = has_previous and turn >= turn_threshold
    if as_printed:
        return normalize(np.where(penalised, turn_penalty, 1.0) * (travelled + length))
    share = normalize(length)
    return np.where(penalised, turn_penalty * (1.0 + share) - 1.0, share)
