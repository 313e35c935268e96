"""Cost of being where a mover is expected: a plan goes round behind it, waits, or leaves the place to it."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.dynamics import Motion

RATE = 20.0
"""Cost by time in the middle of the space that a mover can reach, falling to 0 at its edge."""
MOST_GROWN = 0.15
"""That space grows by so much at most [m]: else nowhere would be free of movers after a while."""
FORESEEN, FORGOTTEN = 1.0, 2.0
"""Up to the first time a prediction counts in full, from the second one on not at all [s]."""


@njit
def mover_cost(movers: np.ndarray, time: float, span: float, motion: Motion) -> float:
    """Cost of a span of time that ends with a motion [s].

    Args:
        movers: (k, 6) of `expected_discs`.
        time: end of the span, from the beginning of the plan [s]; span: its length [s].
        motion: the robot then.
    """
    cost, weight = 0.0, min(1.0, (FORGOTTEN - time) / (FORGOTTEN - FORESEEN))
    if weight <= 0.0:
        return 0.0
    for k in range(len(movers)):
        reach = movers[k, 4] + min(movers[k, 5] * time, MOST_GROWN)
        dx, dy = movers[k, 0] + movers[k, 2] * time - motion.x, movers[k, 1] + movers[k, 3] * time - motion.y
        square = dx * dx + dy * dy
        if square < reach * reach:
            cost += weight * RATE * span * (1.0 - math.sqrt(square) / reach)
    return cost


def expected_discs(rows: np.ndarray, radius: float, clearance: float) -> np.ndarray:
    """(k, 6) x, y [m], vx, vy [m/s], distance [m] to keep between the centres of mover and robot, and its growth [m/s].

    Args:
        rows: (k, 6) of `Movers.rows_at` when the plan begins.
        radius: of the robot [m].
        clearance: kept beyond both radii [m].
    """
    discs = rows.copy()
    discs[:, 4] += radius + clearance
    return discs
