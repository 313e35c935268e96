"""What is solid in a world, as pymunk shapes that a disc can slide along without a seam."""

from collections.abc import Iterator

import numpy as np
import pymunk
import shapely

from collplan_core.worlds import World

COLLINEAR = 1e-9
"""A corner nearer to the chord of its neighbours than this is no corner [m]."""
TOUCHING = 1e-6
"""Circles nearer to each other than this form one surface [m]."""


def wall_shapes(world: World, body: pymunk.Body) -> Iterator[tuple[int, pymunk.Shape]]:
    """The outlines of a world's obstacles as shapes of `body`, each with the number of the surface it belongs to.

    Polygons that overlap or abut are united first and corners that are none are dropped: a disc that slides over the
    seam of two collinear pieces would be thrown off by it.
    """
    surface = 0
    united = shapely.union_all([shapely.Polygon(polygon) for polygon in world.polygons])
    for part in shapely.get_parts(united):
        for ring in (part.exterior, *part.interiors):
            yield from ((surface, segment) for segment in _segments(_corners(ring), body))
            surface += 1
    chains = _chains(np.asarray(world.circles))
    for chain, (x, y, r) in zip(chains, np.asarray(world.circles).tolist(), strict=True):
        yield surface + chain, pymunk.Circle(body, r, (x, y))
    surface += len(chains)
    if world.walled:
        x0, y0, x1, y1 = map(float, world.bounds)
        room = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
        yield from ((surface + side, segment) for side, segment in enumerate(_segments(room, body)))


def _corners(ring: shapely.LinearRing) -> np.ndarray:
    """The corners (n, 2) of a closed ring at which it bends [m]."""
    points = np.asarray(ring.coords)[:-1]
    kept = list(range(len(points)))
    changed = True
    while changed and len(kept) > 3:
        changed = False
        for k in range(len(kept)):
            before, at, after = (points[kept[j % len(kept)]] for j in (k - 1, k, k + 1))
            if _distance_to_chord(at, before, after) < COLLINEAR:
                del kept[k]
                changed = True
                break
    return points[kept]


def _distance_to_chord(point: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    chord = b - a
    length = float(np.hypot(*chord))
    if length == 0.0:
        return float(np.hypot(*(point - a)))
    return abs(float(chord[0] * (point[1] - a[1]) - chord[1] * (point[0] - a[0]))) / length


def _segments(corners: np.ndarray, body: pymunk.Body) -> Iterator[pymunk.Segment]:
    for a, b in zip(corners.tolist(), np.roll(corners, -1, axis=0).tolist(), strict=True):
        yield pymunk.Segment(body, tuple(a), tuple(b), 0.0)


def _chains(circles: np.ndarray) -> list[int]:
    """A number for each circle, the same for those that touch: a wall made of circles is one surface."""
    chain = np.arange(len(circles))
    for i, (x, y, r) in enumerate(circles):
        touching = np.hypot(circles[:, 0] - x, circles[:, 1] - y) <= circles[:, 2] + r + TOUCHING
        chain[np.isin(chain, chain[touching])] = chain[i]
    return chain.tolist()
