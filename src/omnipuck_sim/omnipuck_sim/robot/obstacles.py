"""The world as pymunk shapes, and the contacts of a path with them.

The robot is a disc, so every obstacle is grown by its radius and the robot becomes a point: a contact is where the
point's path meets a grown obstacle. pymunk answers that for a whole step at once, at the exact instant of the touch,
so nothing tunnels and nothing has to be pushed back out.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pymunk

from collplan_core.worlds import World
from omnipuck_sim.robot.vector import Vector

TOUCHING = 1e-6
"""Circles nearer to each other than this form one surface [m]."""

ANYTHING = pymunk.ShapeFilter()


class Contact(NamedTuple):
    """The first contact of a path.

    share: share of the path up to the contact, 0 when it begins in touch.
    normal: unit normal out of the obstacle.
    surface: id of what is touched.
    depth: how deep the path's start lies inside, 0 but for rounding [m].
    """

    share: float
    normal: Vector
    surface: int
    depth: float = 0.0


class Obstacles:
    """Everything solid in a world, for a disc of the given radius [m]."""

    def __init__(self, world: World, radius: float) -> None:
        self._space = pymunk.Space()
        self._surfaces: dict[pymunk.Shape, int] = {}
        self._room = _room(world, radius)
        for surface, shape in _grown(world, radius, self._space.static_body):
            self._space.add(shape)
            self._surfaces[shape] = surface

    def first_contact(self, start: Vector, end: Vector) -> Contact | None:
        """First contact of the disc's centre on its way from start to end [m], none if the way is free."""
        hit = self._space.segment_query_first(start, end, 0.0, ANYTHING)
        if hit is None or hit.shape is None:
            return None
        surface = self._surfaces[hit.shape]
        if hit.alpha > 0.0:
            return Contact(hit.alpha, hit.normal, surface)
        # a start in touch, by rounding: there the query's normal has no length or points inward
        nearest = hit.shape.point_query(start)
        return Contact(0.0, nearest.gradient, surface, max(-nearest.distance, 0.0))

    def clearance(self, position: Vector) -> float:
        """Distance of the disc from the nearest obstacle, negative inside or beyond a wall [m]."""
        (x, y), (x_min, y_min, x_max, y_max) = position, self._room
        nearest = self._space.point_query_nearest(position, np.inf, ANYTHING)
        from_shapes = np.inf if nearest is None else nearest.distance
        return float(min(from_shapes, x - x_min, y - y_min, x_max - x, y_max - y))


def _grown(world: World, radius: float, body: pymunk.Body) -> Iterator[tuple[int, pymunk.Shape]]:
    n = len(world.polygons)
    for surface, polygon in enumerate(world.polygons):
        yield surface, pymunk.Poly(body, np.asarray(polygon).tolist(), radius=radius)
    for chain, (x, y, r) in zip(_chains(world.circles), np.asarray(world.circles).tolist(), strict=True):
        yield n + chain, pymunk.Circle(body, r + radius, (x, y))
    if world.walled:
        x0, y0, x1, y1 = map(float, world.bounds)
        corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
        for side in range(4):
            wall = pymunk.Segment(body, corners[side], corners[(side + 1) % 4], radius)
            yield n + len(world.circles) + side, wall


def _room(world: World, radius: float) -> tuple[float, float, float, float]:
    """Bounds of the disc's centre within the walls: x_min, y_min, x_max, y_max [m]."""
    if not world.walled:
        return -np.inf, -np.inf, np.inf, np.inf
    x_min, y_min, x_max, y_max = map(float, world.bounds)
    return x_min + radius, y_min + radius, x_max - radius, y_max - radius


def _chains(circles: np.ndarray) -> list[int]:
    """A number for each circle, the same for those that touch: a wall made of circles is one surface."""
    chain = np.arange(len(circles))
    for i, (x, y, r) in enumerate(circles):
        touching = np.hypot(circles[:, 0] - x, circles[:, 1] - y) <= circles[:, 2] + r + TOUCHING
        chain[np.isin(chain, chain[touching])] = chain[i]
    return chain.tolist()
