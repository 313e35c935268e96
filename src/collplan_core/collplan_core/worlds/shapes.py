"""World: convex polygons, circles, movers, the arena's bounds, what surrounds them, and the ends of a run."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from collplan_core.validation import finite
from collplan_core.worlds.movers import Mover

POLYGON_FORM = "expected at least 3 corners [x, y] [m] of a convex polygon, in order"
MOST_OBSTACLES = 10_000
"""Obstacles of a world: a route through as many is found in 5 s."""
BOUNDS_FORM = "expected [x_min, y_min, x_max, y_max] [m] with x_min < x_max and y_min < y_max"


class WorldError(ValueError):
    """A world that cannot be used; the message names the key (and the file), the value and the expected form."""


@dataclass(frozen=True, eq=False)
class World:
    """Obstacles and bounds in the world frame, whatever the robot.

    Raises:
        WorldError: at construction, when a shape is degenerate or not convex, a number is not finite, there are more
            than MOST_OBSTACLES, or start, goal or a mover's way point lie outside the bounds or in an obstacle. A robot
            needs more room than a point: see `check_route`.
    """

    name: str  # name of a shipped arena, a file's stem, or "family:seed"
    polygons: tuple[np.ndarray, ...]  # each (k, 2), convex; counter-clockwise whichever way they were given [m]
    circles: np.ndarray  # (c, 3) x, y, radius [m]
    bounds: tuple[float, float, float, float]  # x_min, y_min, x_max, y_max of the arena [m]; obstacles may reach beyond
    walled: bool = True  # the bounds are solid walls; otherwise beams and robot can leave the arena
    start: np.ndarray | None = None  # start, goal: (2,) [m], or None
    goal: np.ndarray | None = None
    source: str = ""  # path of the file that it was read from, else empty
    movers: tuple[Mover, ...] = ()  # what walks through it

    def __repr__(self) -> str:
        """Summary in a line: name and number of obstacles."""
        return f"World({self.called}, {len(self.polygons)} polygons, {len(self.circles)} circles)"

    @property
    def called(self) -> str:
        """Name of the world in error messages: its file where it has one, else its name."""
        return self.source or self.name

    def __post_init__(self) -> None:
        count = len(self.polygons) + len(self.circles)
        if count > MOST_OBSTACLES:
            raise WorldError(f"polygons and circles: got {count}, expected at most {MOST_OBSTACLES}")
        polygons = tuple(_checked_polygon(f"polygons[{i}]", corners) for i, corners in enumerate(self.polygons))
        object.__setattr__(self, "polygons", polygons)
        object.__setattr__(self, "circles", _checked_circles(self.circles))
        object.__setattr__(self, "bounds", _checked_bounds(self.bounds))
        for key in ("start", "goal"):
            if getattr(self, key) is not None:
                object.__setattr__(self, key, self._checked_point(key, getattr(self, key)))
        for i, mover in enumerate(self.movers):
            for j, point in enumerate(mover.way):
                self._checked_point(f"movers[{i}].way[{j}]", point)

    def _checked_point(self, key: str, value: Any) -> np.ndarray:
        point = _finite(key, value, (2,), "expected [x, y] [m]")
        if not in_bounds(self.bounds, point):
            expected = f"expected a point within {list(self.bounds)}"
            raise WorldError(f"{key}: {point.tolist()} is outside the arena, {expected}")
        obstacle = obstacle_at(self, point)
        if obstacle:
            raise WorldError(f"{key}: {point.tolist()} is inside {obstacle}, expected a free point")
        return point


def world_segments(world: World) -> np.ndarray:
    """(s, 4) x0, y0, x1, y1 of every polygon's edges, counter-clockwise, then of the walls if there are any [m]."""
    loops = list(world.polygons)
    if world.walled:
        x0, y0, x1, y1 = world.bounds
        loops.append(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))
    edges = [np.hstack([corners, np.roll(corners, -1, axis=0)]) for corners in loops]
    return np.vstack(edges) if edges else np.zeros((0, 4))


def in_bounds(bounds: Sequence[float], point: np.ndarray) -> bool:
    """Returns whether a point (2,) [m] lies within the bounds, border included."""
    return bool(bounds[0] <= point[0] <= bounds[2] and bounds[1] <= point[1] <= bounds[3])


def obstacle_at(world: World, point: np.ndarray) -> str:
    """Key of the obstacle that a point (2,) [m] lies in, such as "circles[0]"; empty when it lies in none."""
    for i, corners in enumerate(world.polygons):
        edges = np.roll(corners, -1, axis=0) - corners
        if (_cross(edges, point - corners) >= 0.0).all():
            return f"polygons[{i}]"
    for i, (x, y, radius) in enumerate(world.circles):
        if np.hypot(point[0] - x, point[1] - y) <= radius:
            return f"circles[{i}]"
    return ""


def _checked_polygon(key: str, value: Any) -> np.ndarray:
    corners = _finite(key, value, (None, 2), POLYGON_FORM)
    if len(corners) < 3:
        raise WorldError(f"{key}: got {len(corners)} corners, {POLYGON_FORM}")
    edges = np.roll(corners, -1, axis=0) - corners
    if (np.hypot(*edges.T) < 1e-9).any():
        raise WorldError(f"{key}: two corners in a row are equal, {POLYGON_FORM}")
    before = np.roll(edges, 1, axis=0)
    turns = np.arctan2(_cross(before, edges), (before * edges).sum(axis=1))
    area = 0.5 * _cross(corners - corners[0], np.roll(corners, -1, axis=0) - corners[0]).sum()
    if abs(abs(turns.sum()) - 2 * np.pi) > 1e-6 or abs(area) < 1e-12:
        raise WorldError(f"{key}: crosses itself or encloses no area, {POLYGON_FORM}")
    inward = np.flatnonzero(turns * np.sign(area) < -1e-9)
    if len(inward):
        raise WorldError(f"{key}: not convex at corner {inward[0]}, {corners[inward[0]].tolist()}, {POLYGON_FORM}")
    return _frozen(corners if area > 0.0 else corners[::-1])


def _checked_circles(value: Any) -> np.ndarray:
    if len(value) == 0:
        return _frozen(np.zeros((0, 3)))
    circles = _finite("circles", value, (None, 3), "expected a row x, y, radius [m] for each")
    for i, radius in enumerate(circles[:, 2]):
        if radius <= 0.0:
            raise WorldError(f"circles[{i}].radius: got {radius:g}, expected a number above 0 [m]")
    return circles


def _checked_bounds(value: Any) -> tuple[float, float, float, float]:
    x0, y0, x1, y1 = _finite("bounds", value, (4,), BOUNDS_FORM).tolist()
    if not (x0 < x1 and y0 < y1):
        raise WorldError(f"bounds: got {[x0, y0, x1, y1]}, {BOUNDS_FORM}")
    return x0, y0, x1, y1


def _finite(key: str, value: Any, shape: tuple[int | None, ...], form: str) -> np.ndarray:
    return _frozen(finite(key, value, shape, form, WorldError))


def _frozen(array: np.ndarray) -> np.ndarray:
    array = np.ascontiguousarray(array)
    array.flags.writeable = False
    return array


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def largest_rectangles_beside(rectangles: np.ndarray, side: float) -> np.ndarray:
    """Every largest rectangle of [0, side]^2 outside of `rectangles` (n, 4) x0, y0, x1, y1: (m, 4) [m].

    They overlap, so that each face of what is left is the edge of one of them, without a seam.
    """
    xs = np.unique([0.0, side, *rectangles[:, [0, 2]].ravel()])
    ys = np.unique([0.0, side, *rectangles[:, [1, 3]].ravel()])
    left = _cells_left(rectangles, xs, ys)
    blocks = list(_blocks(left))
    largest = [block for block in blocks if not any(_within(block, other) for other in blocks if other != block)]
    return np.array([[xs[i0], ys[j0], xs[i1], ys[j1]] for i0, j0, i1, j1 in largest]).reshape(-1, 4)


def _cells_left(rectangles: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
    """Mask of the cells between the lines xs and ys that no rectangle covers."""
    x, y = np.meshgrid((xs[:-1] + xs[1:]) / 2, (ys[:-1] + ys[1:]) / 2, indexing="ij")
    x0, y0, x1, y1 = rectangles.T[:, :, None, None]
    return ~((x0 < x) & (x < x1) & (y0 < y) & (y < y1)).any(axis=0)


def _blocks(left: np.ndarray) -> Iterator[tuple[int, int, int, int]]:
    for i0, i1 in combinations(range(left.shape[0] + 1), 2):
        for j0, j1 in combinations(range(left.shape[1] + 1), 2):
            if left[i0:i1, j0:j1].all():
                yield i0, j0, i1, j1


def _within(block: tuple[int, ...], other: tuple[int, ...]) -> bool:
    return block[0] >= other[0] and block[1] >= other[1] and block[2] <= other[2] and block[3] <= other[3]
