"""The families `l`, `u`, `z` and `serpentine`: one corridor with right-angled turns, all around it solid."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from collplan_core.worlds.placement import BODY_WIDTH, SIDE, Draw, Layout, rounded
from collplan_core.worlds.shapes import largest_rectangles_beside

# beside the robot [m]
SPARE = (0.08, 0.40)
ROW_SPARE = (0.15, 0.30)
# along the middle of the corridor, to its end wall [m]
ARM = (1.2, 2.0)
Z_ARM = (0.8, 1.4)
# from end wall to end wall [m]
ROW = (1.0, 1.5)
# of solid between two arms [m]
U_SEPTUM = (0.04, 0.25)
Z_SEPTUM = (0.2, 1.0)
ROW_SEPTUM = (0.04, 0.12)
# start and goal from their end walls [m]
INSET = (0.14, 0.20)
# the least of solid between a corridor and the walls of the square [m]
MARGIN = 0.05

EAST, NORTH, WEST = np.array([1.0, 0.0]), np.array([0.0, 1.0]), np.array([-1.0, 0.0])


@dataclass(frozen=True, eq=False)
class Leg:
    """A straight piece of corridor: unit direction (2,), length along its middle from turn to turn, clear width [m]."""

    direction: np.ndarray
    length: float
    width: float


def lay_out_l(draw: Draw) -> Layout | None:
    """Two arms that meet at a right angle."""
    first, second = _widths(draw, SPARE, 2)
    return _corridor(draw, [Leg(EAST, draw(*ARM), first), Leg(NORTH, draw(*ARM), second)])


def lay_out_u(draw: Draw) -> Layout | None:
    """Two arms side by side and the turn between them."""
    first, turn, second = _widths(draw, SPARE, 3)
    across = draw(*U_SEPTUM) + (first + second) / 2
    legs = [Leg(EAST, draw(*ARM), first), Leg(NORTH, across, turn), Leg(WEST, draw(*ARM), second)]
    return _corridor(draw, legs)


def lay_out_z(draw: Draw) -> Layout | None:
    """Two arms that lead the same way, one beside the other, and a piece across that joins them."""
    first, middle, second = _widths(draw, SPARE, 3)
    across = draw(*Z_SEPTUM) + (first + second) / 2
    legs = [Leg(EAST, draw(*Z_ARM), first), Leg(NORTH, across, middle), Leg(EAST, draw(*Z_ARM), second)]
    return _corridor(draw, legs)


def lay_out_serpentine(draw: Draw) -> Layout | None:
    """Four rows of the same length side by side, joined by three U turns."""
    rows, turns = _widths(draw, ROW_SPARE, 4), _widths(draw, ROW_SPARE, 3)
    across = [draw(*ROW_SEPTUM) + (row + after) / 2 for row, after in pairwise(rows)]
    length = draw(*ROW)
    # a row's middle ends in the middle of its turns; start and goal have an end wall instead
    ends = [0.0, *turns, 0.0]
    lengths = [length - (before + after) / 2 for before, after in pairwise(ends)]
    legs = [Leg(EAST, lengths[0], rows[0])]
    for i, turn in enumerate(turns):
        legs.append(Leg(NORTH, across[i], turn))
        legs.append(Leg(EAST if i % 2 else WEST, lengths[i + 1], rows[i + 1]))
    return _corridor(draw, legs)


def _widths(draw: Draw, spare: tuple[float, float], n: int) -> list[float]:
    return [BODY_WIDTH + draw(*spare) for _ in range(n)]


def _corridor(draw: Draw, legs: Sequence[Leg]) -> Layout | None:
    """The corridor somewhere in the square, or None where it is too large for it."""
    free = _rectangles(legs)
    low, high = free[:, :2].min(axis=0), free[:, 2:].max(axis=0)
    room = SIDE - 2 * MARGIN - (high - low)
    if room.min() < 0.0:
        return None
    shift = MARGIN - low + [draw(0.0, room[0]), draw(0.0, room[1])]
    start = draw(*INSET) * legs[0].direction
    goal = sum(leg.length * leg.direction for leg in legs) - draw(*INSET) * legs[-1].direction
    solids = largest_rectangles_beside(rounded(free + np.tile(shift, 2)), SIDE)
    return Layout(solids, start + shift, goal + shift)


def _rectangles(legs: Sequence[Leg]) -> np.ndarray:
    """(n, 4) x0, y0, x1, y1 of the legs one after the other from (0, 0) [m]; two that meet share the turn's corner."""
    widths = [0.0, *(leg.width for leg in legs), 0.0]
    rectangles = []
    tip = np.zeros(2)
    for leg, before, after in zip(legs, widths, widths[2:], strict=False):
        ends = tip - before / 2 * leg.direction, tip + (leg.length + after / 2) * leg.direction
        half = leg.width / 2 * np.abs(leg.direction[::-1])
        rectangles.append([*(np.minimum(*ends) - half), *(np.maximum(*ends) + half)])
        tip = tip + leg.length * leg.direction
    return np.array(rectangles)
