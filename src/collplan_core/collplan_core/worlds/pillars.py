"""The family `pillars`: two rows across a room, each with a narrow passage near the way and a wide one off it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from collplan_core.worlds.placement import BODY_WIDTH, SIDE, Draw, Layout, rounded

THICKNESS = (0.12, 0.30)
# beside the robot [m]
NARROW_SPARE = (0.08, 0.25)
WIDE_SPARE = (0.35, 0.50)
# of a narrow passage's middle from the straight line between start and goal [m]
OFFSET = (0.35, 0.70)
# by how much the way through both wide passages is longer than through both narrow ones
DETOUR = (1.10, 1.22)
# the least that any other way is longer: more than the square that the robot is taken for below can be wrong
OTHERWISE = 1.02
# the least of solid beside a passage [m]
PILLAR = 0.12
# of a row's middle from where equal chambers would have it [m]
SHIFT = 0.10
# start and goal: from the end of the room, and from its middle line [m]
INSET = (0.14, 0.30)
FROM_MIDDLE = 0.3

Interval = tuple[float, float]


@dataclass(frozen=True)
class Row:
    """A row across the room: its extent along x, and along y its narrow and its wide passage [m]."""

    x: Interval
    narrow: Interval
    wide: Interval


def lay_out_pillars(draw: Draw) -> Layout | None:
    """Start and goal at opposite ends; the shortest way leads through the narrow passages."""
    start = draw(*INSET), SIDE / 2 + draw(-FROM_MIDDLE, FROM_MIDDLE)
    goal = SIDE - draw(*INSET), SIDE / 2 + draw(-FROM_MIDDLE, FROM_MIDDLE)
    rows = [_row(draw, SIDE * (i + 1) / 3, start, goal) for i in range(2)]
    if not (all(_fits(row) for row in rows) and _pays_to_squeeze(rows, start, goal)):
        return None
    solids = [rectangle for row in rows for rectangle in _pillars(row)]
    return Layout(rounded(solids), np.array(start), np.array(goal))


def _row(draw: Draw, x: float, start: Interval, goal: Interval) -> Row:
    middle, half = x + draw(-SHIFT, SHIFT), draw(*THICKNESS) / 2
    line = start[1] + (goal[1] - start[1]) * (middle - start[0]) / (goal[0] - start[0])
    side = 1.0 if draw(0.0, 1.0) < 0.5 else -1.0
    narrow = _around(line + side * draw(*OFFSET), BODY_WIDTH + draw(*NARROW_SPARE))
    wide = _around(draw(0.0, SIDE), BODY_WIDTH + draw(*WIDE_SPARE))
    return Row((middle - half, middle + half), narrow, wide)


def _around(middle: float, width: float) -> Interval:
    return middle - width / 2, middle + width / 2


def _fits(row: Row) -> bool:
    first, second = sorted((row.narrow, row.wide))
    return first[0] >= PILLAR and second[0] - first[1] >= PILLAR and second[1] <= SIDE - PILLAR


def _pays_to_squeeze(rows: Sequence[Row], start: Interval, goal: Interval) -> bool:
    ways = [way_length(rows, passages, start, goal) for passages in product(("narrow", "wide"), repeat=len(rows))]
    return min(ways[1:]) >= OTHERWISE * ways[0] and DETOUR[0] <= ways[-1] / ways[0] <= DETOUR[1]


def way_length(rows: Sequence[Row], passages: Sequence[str], start: Interval, goal: Interval) -> float:
    """Length [m] of the shortest way for the robot's centre through the passages named, "narrow" or "wide" by row.

    The robot is taken for a square: its centre keeps to what lies between the faces grown by half its width.
    """
    half = BODY_WIDTH / 2
    gates = []
    for row, name in zip(rows, passages, strict=True):
        low, high = getattr(row, name)
        gates += [(x, low + half, high - half) for x in (row.x[0] - half, row.x[1] + half)]
    return _taut(gates, start, goal)


def _taut(gates: Sequence[tuple[float, float, float]], start: Interval, goal: Interval) -> float:
    """Length of the shortest way through gates x, low, high in order of x: it bends at their ends alone."""
    stations = [[start], *([(x, low), (x, high)] for x, low, high in gates), [goal]]
    shortest = {start: 0.0}
    for i, station in enumerate(stations[1:], 1):
        for point in station:
            shortest[point] = min(
                shortest[other] + math.dist(other, point)
                for j in range(i)
                for other in stations[j]
                if all(_crosses(gate, other, point) for gate in gates[j : i - 1])
            )
    return shortest[goal]


def _crosses(gate: tuple[float, float, float], a: Interval, b: Interval) -> bool:
    x, low, high = gate
    y = a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])
    return low - 1e-9 <= y <= high + 1e-9


def _pillars(row: Row) -> list[list[float]]:
    first, second = sorted((row.narrow, row.wide))
    ends = [(0.0, first[0]), (first[1], second[0]), (second[1], SIDE)]
    return [[row.x[0], low, row.x[1], high] for low, high in ends]
