"""Where a disc's centre can be in a world that is one corridor with right-angled turns: boxes joined by corners."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from collplan_core.worlds import World, WorldError
from collplan_core.worlds.shapes import largest_rectangles_beside


@dataclass(frozen=True, eq=False)
class Region:
    """A part of the free space of a disc's centre: a rectangle, less what is too near one corner of a wall."""

    low: np.ndarray  # (2,) the rectangle's least x and y [m]
    high: np.ndarray  # (2,) its largest [m]
    vertex: np.ndarray | None = None
    """(2,) corner of a wall, from which the centre must be a radius away [m]; None where all is free."""


@dataclass(frozen=True, eq=False)
class FreeChain:
    """The free space of a disc's centre, in parts that each overlap the next.

    Whoever goes from start to goal is in each box in turn.
    """

    regions: tuple[Region, ...]  # box, corner, box, ..., box; together they are the free space
    start: np.ndarray  # (2,) in the first box [m]
    goal: np.ndarray  # (2,) in the last box [m]


def free_chain(world: World, radius: float) -> FreeChain:
    """The free space of the centre of a disc of `radius` [m] in a world of one corridor with right-angled turns.

    A box is one of the largest free rectangles without what is nearer than the radius to its sides. A corner is where
    two of them cross, without what is too near the walls there: it holds what of the turn neither box has.

    Raises:
        WorldError: the world is of another kind, or the disc does not fit into it.
    """
    if world.start is None or world.goal is None:
        raise _another_kind(world)
    rectangles = _in_order(world, _free_rectangles(world), radius, world.start, world.goal)
    regions = [_box(rectangles[0], radius)]
    for before, after in pairwise(rectangles):
        regions += [_corner(world, before, after, radius), _box(after, radius)]
    return FreeChain(tuple(regions), world.start, world.goal)


def _box(rectangle: np.ndarray, radius: float) -> Region:
    return Region(rectangle[:2] + radius, rectangle[2:] - radius)


def _corner(world: World, before: np.ndarray, after: np.ndarray, radius: float) -> Region:
    low, high = np.maximum(before[:2], after[:2]), np.minimum(before[2:], after[2:])
    goes_on_below = np.minimum(before[:2], after[:2]) < low
    goes_on_above = np.maximum(before[2:], after[2:]) > high
    if (goes_on_below == goes_on_above).any():
        raise _another_kind(world)
    return Region(
        np.where(goes_on_below, low, low + radius),
        np.where(goes_on_above, high, high - radius),
        np.where(goes_on_below, low, high),
    )


def _free_rectangles(world: World) -> np.ndarray:
    """(n, 4) x0, y0, x1, y1 of every largest free rectangle [m]."""
    side = world.bounds[2]
    boxes = [(corners.min(axis=0), corners.max(axis=0)) for corners in world.polygons]
    upright = all(
        len(corners) == 4 and ((corners == low) | (corners == high)).all()
        for corners, (low, high) in zip(world.polygons, boxes, strict=True)
    )
    if len(world.circles) or not upright or not world.walled or world.bounds != (0.0, 0.0, side, side):
        raise _another_kind(world)
    return largest_rectangles_beside(np.clip(np.array(boxes).reshape(-1, 4), 0.0, side), side)


def _in_order(world: World, rectangles: np.ndarray, radius: float, start: np.ndarray, goal: np.ndarray) -> np.ndarray:
    """The rectangles from the start's to the goal's, where each crosses its neighbours in that order and no other."""
    low, high = rectangles[:, :2], rectangles[:, 2:]
    holds_start, holds_goal = (
        np.all((low + radius <= point) & (point <= high - radius), axis=1) for point in (start, goal)
    )
    crosses = (np.minimum(high[:, None], high) > np.maximum(low[:, None], low)).all(axis=2)
    np.fill_diagonal(crosses, False)
    order: list[int] = []
    following = np.flatnonzero(holds_start & (crosses.sum(axis=1) <= 1)).tolist()
    while len(following) == 1:
        order += following
        following = [i for i in np.flatnonzero(crosses[order[-1]]).tolist() if i not in order]
    is_chain = 0 < len(order) == len(rectangles) and crosses.sum() == 2 * (len(order) - 1)
    if not is_chain or not holds_goal[order[-1]] or (high - low <= 2 * radius).any():
        raise _another_kind(world)
    return rectangles[order]


def _another_kind(world: World) -> WorldError:
    return WorldError(
        f"{world.name}: no chain of boxes, expected a walled square of upright rectangles that leave one corridor with "
        "right-angled turns, wide enough for the robot, with start and goal at its ends"
    )
