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

    Attributes:
        stamp: stamp of its scan [s].
        position: (2,) centre of F: the robot, or the nearest point out of a grown obstacle [m].
        radius: disc by which obstacles are grown [m].
        half_side: half the side of the square map [m].
        reach: (n,) free distance of the disc's centre in direction 2 pi k / n [m].
        border_points: (n, 2) the border of F, counter-clockwise [m].
        surface: (n,) number of the observed surface that ends each direction; -1 map border, -2 unseen.
        normals: (n, 2) unit normal out of the observed surface; zero elsewhere.
        shadow: (n,) whether the border of F from direction k to k + 1 is a shadow edge.
        segments: (m, 4) straight frontier segments x0, y0, x1, y1, counter-clockwise [m].
        frontier_kind: (m,) 0 shadow edge, 1 border run.
        frontier_number: (m,) the frontier B_i a segment belongs to.
        open_side: (m, 2) whether F is seen to be open clockwise, counter-clockwise of the segment.
        predicted: (e, 4) set E: origin and unit tangent into unseen space.
        walls: (w, 4) straight pieces x0, y0, x1, y1 along the observed surfaces themselves, not grown [m].
        wall_surface: (w,) number of the surface a wall is of.
        view: (b,) how far each beam saw: a hit's range, inf without a hit, 0 unseen [m].
        view_from: (4,) where the beams begin x, y [m], bearing of the first one, angle between two [rad].
        view_beams: (b, 3) where each begins x, y [m], of which view_from has the middle one, and how much farther it is
            turned [rad]; (0, 3) where all are of one place.
        returns: what stands and what moves of what it was built from; returns of movers are not in the rest of it.
        unseen: what its scan has out of view, and none before had in view.
    """

    stamp: float
    position: np.ndarray
    radius: float
    half_side: float
    reach: np.ndarray
    border_points: np.ndarray
    surface: np.ndarray
    normals: np.ndarray
    shadow: np.ndarray
    segments: np.ndarray
    frontier_kind: np.ndarray
    frontier_number: np.ndarray
    open_side: np.ndarray
    predicted: np.ndarray
    walls: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))
    wall_surface: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))
    view: np.ndarray = field(default_factory=lambda: np.zeros(0))
    view_from: np.ndarray = field(default_factory=lambda: np.zeros(4))
    view_beams: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    returns: SortedReturns = ALL_STANDS
    unseen: Unseen = ALL_SEEN

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
