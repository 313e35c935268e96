"""Gaps that measure a little too narrow for the disc, and how often the robot has tried each of them."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from collplan_core.control.stuck import WINDOW
from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import ClearanceField, Grid, clearance_at
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import waypoint_near
from collplan_core.time_to_goal_planner.shortest_paths.record import PathLookup, ShortestPaths

TIGHT = 0.01
"""A gap that the disc just fits through may measure narrower by twice this [m]."""
NEAR = 0.05
"""The robot is at a gap so far before it would touch both of its sides [m]."""
AWAY = 0.15
"""It has left where it is so much farther from it [m]."""
SAMPLING = 0.01
"""Spacing of the places on a path at which it is compared with the boundaries [m]."""


@dataclass(frozen=True, eq=False)
class TriedGaps:
    """The gaps that were tried on the way to a goal."""

    places: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))  # (n, 2) their narrowest places [m]
    tries: np.ndarray = field(default_factory=lambda: np.zeros(0, int))  # (n,) how often the robot has come to each
    at: int = -1  # index of the gap that the robot is at, -1 where it is at none
    since: float = 0.0  # stamp since when it is there [s]

    def closed(self, most: int) -> np.ndarray:
        """Places (k, 2) of the gaps that were tried `most` times and have not let the robot through [m]."""
        elsewhere = np.arange(len(self.tries)) != self.at
        return self.places[(self.tries >= most) & elsewhere]


def widened(clearance: ClearanceField, closed: np.ndarray, radius: float) -> ClearanceField:
    """Boundaries as if all gaps were wider by twice TIGHT, but for the `closed` ones (k, 2) [m] and a radius around."""
    wider = clearance.clearance + TIGHT
    for place in closed:
        first = np.maximum(np.floor((place - radius - clearance.origin) / clearance.spacing).astype(int), 0)
        last = np.maximum(np.ceil((place + radius - clearance.origin) / clearance.spacing).astype(int) + 1, 0)
        around = np.s_[first[0] : last[0], first[1] : last[1]]
        wider[around] = clearance.clearance[around]
    return replace(clearance, clearance=wider)


def gap_on_the_way(paths: ShortestPaths, clearance: ClearanceField, position: np.ndarray) -> np.ndarray | None:
    """The narrowest place (2,) of the first gap too narrow for the disc on the path from a position; None without."""
    x, y = (float(value) for value in position)
    found, gx, gy = _first_gap(paths.lookup(paths.tolerance), clearance.clearance, clearance.grid, x, y)
    return np.array([gx, gy]) if found else None


@njit
def _first_gap(paths: PathLookup, clearance: np.ndarray, grid: Grid, x: float, y: float) -> tuple[bool, float, float]:
    k = waypoint_near(paths, x, y)
    narrowest, gx, gy = 0.0, x, y
    while k >= 0:
        ahead_x, ahead_y = paths.waypoints[k]
        length = math.hypot(ahead_x - x, ahead_y - y)
        count = int(length / SAMPLING) + 1
        for i in range(count + 1):
            px, py = x + i / count * (ahead_x - x), y + i / count * (ahead_y - y)
            here = clearance_at(clearance, grid, px, py)
            if here < narrowest:
                narrowest, gx, gy = here, px, py
            elif narrowest < 0.0 <= here:
                return True, gx, gy
        if k == 0:
            break
        x, y = ahead_x, ahead_y
        following = waypoint_near(paths, x, y)
        k = following if following < k else -1
    return narrowest < 0.0, gx, gy


def with_try(tried: TriedGaps, gap: np.ndarray | None, position: np.ndarray, stamp: float, radius: float) -> TriedGaps:
    """The gaps after one more cycle with the robot at `position` (2,) [m] and a gap (2,) on its way [m], or None.

    It is a try to come to a gap, and another one to come again or to stay for as long as a robot takes to be stuck.
    """
    touching = math.sqrt(2.0 * radius * TIGHT)
    if tried.at >= 0:
        left = math.dist(position, tried.places[tried.at]) > touching + NEAR + AWAY
        return replace(tried, at=-1) if left or stamp - tried.since > WINDOW else tried
    if gap is None or math.dist(position, gap) > touching + NEAR:
        return tried
    same = np.flatnonzero(np.hypot(*(tried.places - gap).T) < radius)
    if len(same) == 0:
        places, tries = np.vstack([tried.places, gap]), np.append(tried.tries, 1)
        return TriedGaps(places, tries, len(tries) - 1, stamp)
    tries = tried.tries.copy()
    tries[same[0]] += 1
    return replace(tried, tries=tries, at=int(same[0]), since=stamp)
