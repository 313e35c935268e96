"""Solid parts of a world, as edges and circles that a disc can slide along without a seam."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely

from collplan_core.worlds import World
from omnipuck_sim.robot.vector import Vector

COLLINEAR = 1e-9
"""A corner nearer to the chord of its neighbours than this is no corner [m]."""
TOUCHING = 1e-6
"""Circles nearer to each other than this form one surface [m]."""


@dataclass(frozen=True)
class Edge:
    """A straight piece of the outline from `a` to `b` [m]; `surface` is the number of the surface it belongs to."""

    surface: int
    a: Vector
    b: Vector


@dataclass(frozen=True)
class Pole:
    """A circle of the outline; its centre and radius in m, `surface` as for an edge."""

    surface: int
    centre: Vector
    radius: float


def outlines(world: World) -> Iterator[Edge | Pole]:
    """The outlines of a world's obstacles, and of its bounds where it is walled.

    Polygons that overlap or abut are united first and corners that are none are dropped: a disc that slides over the
    seam of two collinear pieces would be thrown off by it.
    """
    surface = 0
    united = shapely.union_all([shapely.Polygon(polygon) for polygon in world.polygons])
    for part in shapely.get_parts(united):
        for ring in (part.exterior, *part.interiors):
            yield from (Edge(surface, a, b) for a, b in _sides(_corners(ring)))
            surface += 1
    chains = _chains(np.asarray(world.circles))
    for chain, (x, y, r) in zip(chains, np.asarray(world.circles).tolist(), strict=True):
        yield Pole(surface + chain, (x, y), r)
    surface += len(chains)
    if world.walled:
        x0, y0, x1, y1 = map(float, world.bounds)
        room = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
        yield from (Edge(surface + side, a, b) for side, (a, b) in enumerate(_sides(room)))


def _corners(ring: shapely.LinearRing) -> np.ndarray:
    """The corners (n, 2) of a closed ring at which it bends [m]."""
    points = np.asarray(ring.coords)[:-1]
    before, after = points - np.roll(points, 1, axis=0), np.roll(points, -1, axis=0) - points
    chord = before + after
    return points[np.abs(chord[:, 0] * before[:, 1] - chord[:, 1] * before[:, 0]) >= COLLINEAR * np.hypot(*chord.T)]


def _sides(corners: np.ndarray) -> Iterator[tuple[Vector, Vector]]:
    ends = [(x, y) for x, y in corners.tolist()]
    yield from zip(ends, [*ends[1:], ends[0]], strict=True)


def _chains(circles: np.ndarray) -> list[int]:
    """A number for each circle, the same for those that touch: a wall made of circles is one surface."""
    chain = np.arange(len(circles))
    for i, (x, y, r) in enumerate(circles):
        touching = np.hypot(circles[:, 0] - x, circles[:, 1] - y) <= circles[:, 2] + r + TOUCHING
        chain[np.isin(chain, chain[touching])] = chain[i]
    return chain.tolist()
