"""The sliding local map M as one record."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import inside
from collplan_core.movers.record import ALL_SEEN, ALL_STANDS, SortedReturns, Unseen


@njit
def _contains(border: np.ndarray, points: np.ndarray) -> np.ndarray:
    result = np.empty(len(points), np.bool_)
    for i in range(len(points)):
        result[i] = inside(border, points[i, 0], points[i, 1])
    return result


@dataclass(frozen=True, eq=False)
class LocalMap:
    """Free space, boundaries and frontiers around the robot, in the configuration space of its disc, world frame.

    Paper: II-A. All points but those of `border` are absolute.
    """

    stamp: float  # stamp of its scan [s]
    position: np.ndarray  # (2,) centre of F: the robot, or the nearest point out of a grown obstacle [m]
    radius: float  # disc by which obstacles are grown [m]
    half_side: float  # half the side of the square map [m]
    reach: np.ndarray  # (n,) free distance of the disc's centre in direction 2 pi k / n [m]
    border_points: np.ndarray  # (n, 2) the border of F, counter-clockwise [m]
    surface: np.ndarray  # (n,) number of the observed surface that ends each direction; -1 map border, -2 unseen
    normals: np.ndarray  # (n, 2) unit normal out of the observed surface; zero elsewhere
    shadow: np.ndarray  # (n,) whether the border of F from direction k to k + 1 is a shadow edge
    segments: np.ndarray  # (m, 4) straight frontier segments x0, y0, x1, y1, counter-clockwise [m]
    frontier_kind: np.ndarray  # (m,) 0 shadow edge, 1 border run
    frontier_number: np.ndarray  # (m,) the frontier B_i a segment belongs to
    open_side: np.ndarray  # (m, 2) whether F is seen to be open clockwise, counter-clockwise of the segment
    predicted: np.ndarray  # (e, 4) set E: origin and unit tangent into unseen space
    walls: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))
    """(w, 4) straight pieces x0, y0, x1, y1 along the observed surfaces themselves, not grown [m]."""
    wall_surface: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    """(w,) number of the surface a wall is of."""
    view: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """(b,) how far each beam saw: a hit's range, inf without a hit, 0 unseen [m]."""
    view_from: np.ndarray = field(default_factory=lambda: np.zeros(4))
    """(4,) where the beams begin x, y [m], bearing of the first one, angle between two [rad]."""
    view_beams: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    """(b, 3) where each begins x, y [m], of which view_from has the middle one, and how much farther it is turned
    [rad]; (0, 3) where all are of one place."""
    returns: SortedReturns = ALL_STANDS
    """The returns that the map was built from, standing or moving; no other field has those of movers."""
    unseen: Unseen = ALL_SEEN  # what its scan has out of view, and none before had in view

    def __repr__(self) -> str:
        """One line: place, and counts of its borders."""
        x, y = self.position
        frontiers = len(set(self.frontier_number.tolist()))
        return f"LocalMap(at {x:.2f}, {y:.2f}, {len(self.walls)} pieces of wall, {frontiers} frontiers)"

    @cached_property
    def border(self) -> np.ndarray:
        """(n, 2) the border of F relative to `position` [m]."""
        return self.border_points - self.position

    def contains(self, points: np.ndarray) -> np.ndarray:
        """(k,) whether each of the points (k, 2) lies in F, border included."""
        return _contains(self.border, np.atleast_2d(points) - self.position)
