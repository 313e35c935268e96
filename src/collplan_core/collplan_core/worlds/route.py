"""Test whether a disc can get from one point of a world to another."""

from typing import TYPE_CHECKING

import numpy as np

from collplan_core.worlds.shapes import World, WorldError, in_bounds

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

# 64 pieces to a quarter turn: a grown corner is off by less than a thousandth of a millimetre per centimetre
QUARTER_SEGMENTS = 64
TOUCH = 1e-6
"""Depth up to which a disc in an obstacle touches it [m]; far from the origin, what rounding leaves is added."""


def free_space(world: World, radius: float) -> "BaseGeometry":
    """Returns the free space of the centre of a disc of `radius` [m], as a shapely geometry.

    Without walls the surroundings of the arena belong to it.
    """
    import shapely

    grown = [shapely.Polygon(corners).buffer(radius, quad_segs=QUARTER_SEGMENTS) for corners in world.polygons]
    grown += [shapely.Point(x, y).buffer(r + radius, quad_segs=QUARTER_SEGMENTS) for x, y, r in world.circles]
    obstacles = shapely.union_all(grown)
    arena = shapely.box(*world.bounds)
    if world.walled:
        return arena.buffer(-radius, join_style="mitre").difference(obstacles)
    return arena.union(obstacles).envelope.buffer(3.0 * radius, join_style="mitre").difference(obstacles)


def check_route(world: World, start: np.ndarray, goal: np.ndarray, radius: float, tolerance: float = 0.0) -> None:
    """Check that a route for a disc of `radius` [m] leads from start (2,) to within a tolerance of the goal (2,) [m].

    Raises:
        WorldError: start or goal is not finite, outside the arena or too near to an obstacle or wall to stand there, a
            mover begins on the start, or the goal cannot be reached.
    """
    import shapely

    for key, point, beside in (("start", start, 0.0), ("goal", goal, tolerance)):
        _check_room(world, key, np.asarray(point), radius, beside)
    check_movers_apart(world, start, radius)
    free = free_space(world, radius - 2.0 * touch_depth(world))
    parts = getattr(free, "geoms", [free])
    if not any(part.covers(shapely.Point(start)) and part.distance(shapely.Point(goal)) <= tolerance for part in parts):
        raise WorldError(
            f"{world.called}: goal: {np.asarray(goal).tolist()} cannot be reached from {np.asarray(start).tolist()}, "
            f"expected a route for a disc of radius {radius:g} m"
        )


def check_movers_apart(world: World, start: np.ndarray, radius: float) -> None:
    """Check that no mover begins where a robot of `radius` [m] does, which is at start (2,) [m].

    Raises:
        WorldError: one does.
    """
    for i, mover in enumerate(world.movers):
        apart, least = float(np.hypot(*(mover.way[0] - start))), mover.reach + radius
        if apart < least:
            key = f"{world.called}: movers[{i}].way[0]: {mover.way[0].tolist()}"
            raise WorldError(f"{key} is {apart:.2f} m from the robot's start, expected at least {least:g} m")


def has_room(world: World, point: np.ndarray, radius: float) -> bool:
    """Returns whether a disc of `radius` [m] can stand at a point (2,) [m] of the arena; it may touch obstacles."""
    return in_bounds(world.bounds, point) and clearance(world, point, radius) >= -touch_depth(world)


def touch_depth(world: World) -> float:
    """Depth up to which a disc in an obstacle of this world only touches it [m]."""
    return TOUCH + 16.0 * float(np.spacing(np.abs(world.bounds).max()))


def clearance(world: World, point: np.ndarray, radius: float) -> float:
    """Distance of a disc of `radius` [m] at a point (2,) [m] from the nearest obstacle or wall, negative inside [m]."""
    import shapely

    (x, y), spot = point, shapely.Point(point)
    distances = [np.hypot(x - cx, y - cy) - r for cx, cy, r in world.circles]
    if world.polygons:
        # in their union: an edge within another polygon is no way out
        solid = shapely.union_all([shapely.Polygon(corners) for corners in world.polygons])
        inside = solid.contains(spot)
        distances.append(-shapely.distance(solid.boundary, spot) if inside else shapely.distance(solid, spot))
    if world.walled:
        x_min, y_min, x_max, y_max = world.bounds
        distances += [x - x_min, y - y_min, x_max - x, y_max - y]
    return float(min(distances, default=np.inf)) - radius


def _check_room(world: World, key: str, point: np.ndarray, radius: float, beside: float) -> None:
    if not np.isfinite(point).all() or not in_bounds(world.bounds, point):
        expected = f"expected a point within {list(world.bounds)}"
        raise WorldError(f"{world.called}: {key}: {point.tolist()} is outside the arena, {expected}")
    if not has_room(world, point, radius - beside):
        expected = f"expected {radius:g} m of room around {f'a place within {beside:g} m of it' if beside else 'it'}"
        raise WorldError(f"{world.called}: {key}: {point.tolist()} is in an obstacle or too near one, {expected}")
