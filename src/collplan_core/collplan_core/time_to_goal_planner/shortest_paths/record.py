"""The shortest paths to a goal, as records."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collplan_core.time_to_goal_planner.boundary_memory.clearance import Grid


class PathLookup(NamedTuple):
    """Lookup of the time to go: a part of ShortestPaths, with the tolerance that applies there."""

    length: np.ndarray
    waypoint: np.ndarray
    waypoints: np.ndarray
    onward: np.ndarray
    remaining: np.ndarray
    turning: np.ndarray
    cells: Grid
    goal_x: float
    goal_y: float
    tolerance: float


@dataclass(frozen=True, eq=False)
class ShortestPaths:
    """Any-angle shortest paths of the disc's centre to the goal over what is known; what is unknown is free.

    World frame. Cell [i, j] has its centre at origin + spacing * (i, j). Cells and waypoints from which the goal
    cannot be reached have no path.
    """

    origin: np.ndarray  # (2,) centre of cell [0, 0] [m]
    spacing: float  # spacing of the cells [m]
    blocked: np.ndarray  # (mx, my) bool, cells within known obstacles
    length: np.ndarray  # (mx, my) length of the path, inf where there is none [m]
    waypoint: np.ndarray  # (mx, my) int32, index of the first waypoint, seen in a straight line; -1 where there is none
    waypoints: np.ndarray
    """(w, 2) positions [m]. Number 0 is the goal; where it is blocked, paths end within its tolerance."""
    onward: np.ndarray
    """(w, 2) unit direction in which the path goes on after the turn at the waypoint; (0, 0) at number 0."""
    remaining: np.ndarray  # (w,) length of the path from the waypoint on [m]
    turning: np.ndarray
    """(w,) sum of 1 - cos over the turns after the waypoint's [-]; a turn costs its 1 - cos times
    max_speed / (2 max_acceleration) [s]."""
    goal: np.ndarray  # (2,) position of the goal [m]
    tolerance: float  # distance to the goal that counts as arrived [m]

    def lookup(self, tolerance: float) -> PathLookup:
        """The paths for compiled code, with the distance to the goal that counts as arrived there [m]."""
        x, y = (float(value) for value in self.origin)
        goal_x, goal_y = (float(value) for value in self.goal)
        cells = Grid(x, y, self.spacing)
        return PathLookup(
            self.length,
            self.waypoint,
            self.waypoints,
            self.onward,
            self.remaining,
            self.turning,
            cells,
            goal_x,
            goal_y,
            tolerance,
        )

    def longest_within(self, distance: float) -> float:
        """Length of the longest path to the goal from within a distance of it [m], by the cells in and around that.

        It is more than the distance where a wall stands between the goal and a place that near. Places without a path
        are left out.
        """
        i, j = (int(cell) for cell in np.rint((self.goal - self.origin) / self.spacing))
        reach = math.ceil(distance / self.spacing) + 1
        first_i, first_j = max(i - reach, 0), max(j - reach, 0)
        length = self.length[first_i : i + reach + 1, first_j : j + reach + 1]
        rows, columns = np.indices(length.shape)
        away = self.spacing * np.hypot(rows + first_i - i, columns + first_j - j)
        near = (away < distance + self.spacing) & np.isfinite(length)
        return float(length[near].max(initial=distance))
