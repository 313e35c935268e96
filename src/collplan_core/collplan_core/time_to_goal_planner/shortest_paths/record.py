"""The shortest paths to a goal, as records."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collplan_core.time_to_goal_planner.boundary_memory.clearance import Grid


class PathLookup(NamedTuple):
    """What the time to go is looked up in: a part of ShortestPaths, with the tolerance that counts there."""

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

    Attributes:
        origin: (2,) centre of cell [0, 0] [m].
        spacing: spacing of the cells [m].
        blocked: (mx, my) bool, cells within known obstacles.
        length: (mx, my) length of the path, inf where there is none [m].
        waypoint: (mx, my) int32, index of the first waypoint, seen in a straight line; -1 where there is none.
        waypoints: (w, 2) positions [m]. Number 0 is the goal; where it is blocked, paths end within its tolerance.
        onward: (w, 2) unit direction in which the path goes on after the turn at the waypoint; (0, 0) at number 0.
        remaining: (w,) length of the path from the waypoint on [m].
        turning: (w,) sum of 1 - cos over the turns after the waypoint's [-]; a turn costs its 1 - cos times
            max_speed / (2 max_acceleration) [s].
        goal: (2,) position of the goal [m].
        tolerance: distance to the goal that counts as arrived [m].
    """

    origin: np.ndarray
    spacing: float
    blocked: np.ndarray
    length: np.ndarray
    waypoint: np.ndarray
    waypoints: np.ndarray
    onward: np.ndarray
    remaining: np.ndarray
    turning: np.ndarray
    goal: np.ndarray
    tolerance: float

    def lookup(self, tolerance: float) -> PathLookup:
        """The paths for compiled code, with the distance to the goal that counts as arrived there [m]."""
        x, y = (float(value) for value in self.origin)
        goal_x, goal_y = (float(value) for value in self.goal)
        cells = Grid(x, y, self.spacing)
        return PathLookup(
            self.waypoint, self.waypoints, self.onward, self.remaining, self.turning, cells, goal_x, goal_y, tolerance
        )
