"""Which candidates the robot can drive to without meeting a mover. Not in the paper, in which nothing moves."""

import numpy as np

from collplan_core.movers.record import Movers
from collplan_core.parameters import Settings
from collplan_core.state import State

FORESEEN = np.arange(0.1, 1.05, 0.1)
"""Times at which the robot and the movers are compared [s]."""
PACE = 0.5
"""Share of v_max at which the robot is expected to drive to a candidate."""


def meets_a_mover(points: np.ndarray, movers: Movers, state: State, settings: Settings) -> np.ndarray:
    """(n,) whether the straight way to each of the points (n, 2) [m] leads into a mover within a second.

    Only what the robot comes nearer to than it is counts: a robot beside a mover may leave it.
    """
    if len(movers) == 0:
        return np.zeros(len(points), dtype=bool)
    way = points - state.position
    length = np.maximum(np.hypot(*way.T), 1e-9)
    driven = np.minimum(PACE * settings.robot.max_speed * FORESEEN[:, None] / length, 1.0)
    robot = state.position + driven[:, :, None] * way
    rows = movers.rows_at(state.stamp)
    discs = rows[:, :2] + FORESEEN[:, None, None] * rows[:, 2:4]
    apart = np.hypot(*np.moveaxis(robot[:, :, None] - discs[:, None], -1, 0))
    now = np.hypot(*(state.position - rows[:, :2]).T)
    wanted = np.minimum(settings.robot.radius + rows[:, 4] + settings.movers.clearance, now - 1e-6)
    return np.any(apart < wanted, axis=(0, 2))
