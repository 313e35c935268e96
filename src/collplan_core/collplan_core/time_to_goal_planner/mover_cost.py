"""Cost of being where a mover is expected: a plan goes round behind it, waits, or leaves the place to it.

What no scan has had in view costs as the way does on which a mover came.
"""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.record import LocalMap
from collplan_core.movers.coverage import CELL
from collplan_core.parameters import Settings
from collplan_core.strategies import is_careful
from collplan_core.time_to_goal_planner.dynamics import Motion

RATE = 20.0
"""Cost by time in the middle of the space that a mover can reach, falling to 0 at its edge."""
MOST_GROWN = 0.15
"""That space grows by so much at most [m]: else nowhere would be free of movers after a while."""
WALKING = 0.2
"""What is slower is given less space to grow into, and none at rest, or a gap beside it would be closed [m/s]."""
TRAIL_RATE = 1.5
"""The same for the way on which it came: who walks to and fro comes back."""
ENTERED, CREPT_INTO = 0.7, 4.0
"""What was out of view costs so many times as much, and where the robot only creeps into it."""
EACH, AROUND = 4, 0.15
"""Inside of what was out of view one in so many cells along each axis counts, and so far around it [m]."""
FORESEEN, FORGOTTEN = 1.0, 2.0
"""Up to the first time a prediction counts in full, from the second one on not at all [s]."""


@njit
def mover_cost(movers: np.ndarray, trails: np.ndarray, time: float, span: float, motion: Motion) -> float:
    """Cost [s] of a span [s] of time that ends with a motion, at `time` [s] since the plan began.

    Movers (k, 6) and trails (h, 4) as of `discs_and_trails`.
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
    deepest = 0.0
    for k in range(len(trails)):
        dx, dy, reach = trails[k, 0] - motion.x, trails[k, 1] - motion.y, trails[k, 2]
        square = dx * dx + dy * dy
        if square < reach * reach:
            deepest = max(deepest, trails[k, 3] * (1.0 - math.sqrt(square) / reach))
    return cost + weight * TRAIL_RATE * span * deepest


def discs_and_trails(local_map: LocalMap, now: float, settings: Settings) -> tuple[np.ndarray, np.ndarray]:
    """What a plan that begins at `now` [s] keeps clear of: (k, 6) movers, and (h, 4) ways on which they came.

    A mover has x, y [m], vx, vy [m/s], the distance [m] to keep between its centre and the robot's, and its growth
    [m/s]; a way, or what was out of view, has x, y, the distance to keep [m], and a weight.
    """
    returns, radius = local_map.returns, settings.robot.radius
    if not (len(returns.movers) or len(returns.trails) or len(local_map.unseen.places)):
        return np.zeros((0, 6)), np.zeros((0, 4))
    discs, trails = returns.movers.rows_at(now), np.column_stack([returns.trails, np.ones(len(returns.trails))])
    discs[:, 4] += radius + settings.movers.clearance
    discs[:, 5] *= np.minimum(1.0, np.hypot(discs[:, 2], discs[:, 3]) / WALKING)
    trails[:, 2] += radius
    return discs, np.vstack([trails, _unseen_discs(local_map, settings)])


def _unseen_discs(local_map: LocalMap, settings: Settings) -> np.ndarray:
    """(u, 4) rows of trails that cover what was out of view as far as the robot gets while they count."""
    reach, radius = FORGOTTEN * settings.robot.max_speed, settings.robot.radius
    weight = CREPT_INTO if is_careful(settings.planner.strategy) else ENTERED
    edges, inner = (
        places[np.hypot(*(places - local_map.position).T) < reach]
        for places in (local_map.unseen.edges, local_map.unseen.places)
    )
    inner = inner[(np.rint(inner / CELL) % EACH == 0.0).all(axis=1)]
    apart = np.hypot(*np.moveaxis(inner[:, None] - edges, -1, 0)).min(axis=1, initial=np.inf)
    inner = inner[apart > AROUND]
    around = np.repeat((0.5 * CELL, AROUND), (len(edges), len(inner))) + radius
    return np.column_stack([np.vstack([edges, inner]), around, np.full(len(around), weight)])
