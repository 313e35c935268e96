"""What a world measures, with shapely: its open space, and the free intervals along lines across it."""

from functools import cache
from itertools import pairwise

import numpy as np
import shapely

from collplan_core.worlds import World, load_world

SEEDS = range(40)
SIDE = 2.4
BODY_RADIUS = 0.09
# coordinates are rounded to 0.1 mm, so a width is off by up to as much
ROUNDING = 1.1e-4

Interval = tuple[float, float]


@cache
def worlds(family: str) -> tuple[World, ...]:
    return tuple(load_world(f"{family}:{seed}") for seed in SEEDS)


def open_space(world: World) -> shapely.Geometry:
    return shapely.box(*world.bounds).difference(shapely.union_all([shapely.Polygon(p) for p in world.polygons]))


def chords(world: World, axis: int, at: float) -> list[Interval]:
    """The free intervals, in order, of the line along `axis` at `at` on the other axis."""
    ends = [(-1.0, at), (SIDE + 1.0, at)]
    line = shapely.LineString(ends if axis == 0 else [end[::-1] for end in ends])
    cut = open_space(world).intersection(line)
    bounds = np.array([part.bounds for part in getattr(cut, "geoms", [cut]) if part.length > 0.0])
    return sorted((low, high) for low, high in bounds[:, [axis, axis + 2]].tolist())


def chord_at(world: World, axis: int, point: np.ndarray) -> Interval:
    return next((a, b) for a, b in chords(world, axis, point[1 - axis]) if a <= point[axis] <= b)


def lengths(intervals: list[Interval]) -> np.ndarray:
    return np.array([high - low for low, high in intervals])


def gaps(intervals: list[Interval]) -> list[Interval]:
    return [(before[1], after[0]) for before, after in pairwise(intervals)]


def assert_within(values, low: float, high: float) -> None:
    assert np.min(values) >= low - ROUNDING
    assert np.max(values) <= high + ROUNDING


def across_start(world: World) -> int:
    """The axis across the corridor at the start."""
    widths = [lengths([chord_at(world, axis, world.start)])[0] for axis in (0, 1)]
    return int(np.argmin(widths))
