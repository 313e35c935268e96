"""What the accepted scans had in view, and the places out of view that none of them had: these are not free.

A sector that a scan leaves out, or in which it measured nothing, hides what no earlier scan showed. What a wall hides
is in view: the direction counts.
"""

import math
from dataclasses import dataclass

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.seen import SeenSurfaces
from collplan_core.local_map.surfaces import UNSEEN
from collplan_core.movers.record import ALL_SEEN, Unseen
from collplan_core.movers.unseen import NARROW
from collplan_core.scan import Scan
from collplan_core.sight_lines import place_towards
from collplan_core.state import State

CELL = 0.05
"""Side of the square cells that are kept [m]."""
REACH = 2.5
"""A scan tells of so much around the robot [m]; it is farther than any braking."""
HALF = 120
"""Cells to each side of the middle one; the robot is at least REACH from the edge."""
NEXT = 1.5
"""Beams so far apart are neighbours with nothing between [beams]."""
UNKNOWN, SOLID, FREE = 0, 1, 2
"""Kinds of a cell: no scan saw it, at what a beam met or just behind, seen to be free."""
BEHIND = 1.5
"""What a beam met reaches so many cells deep: nothing comes out of a wall."""
BLOCK = 6
"""Cells along each side of a block: all behind walls together, most of them need not be looked at one by one."""


@dataclass(frozen=True, eq=False)
class Coverage:
    """What the scans so far saw, world frame."""

    cells: np.ndarray  # (2 HALF + 1, 2 HALF + 1) uint8, UNKNOWN, SOLID or FREE
    first: np.ndarray  # (2,) int, cell [0, 0]: its middle is at first * CELL [m]
    last: np.ndarray  # (2,) where the robot was when a scan was added [m]


def with_view(before: Coverage | None, seen: SeenSurfaces, state: State, radius: float) -> tuple[Coverage, Unseen]:
    """What the scans so far saw, with one more that is taken at `state`, and what it leaves unseen.

    `before` is after the scan before, None at the first. Surfaces in the scan include those of movers: they hide what
    is behind them, as walls do. The robot stands on what is free, a disc of `radius` [m].
    """
    measured = seen.kind != UNSEEN
    enough = before if before is not None and math.dist(state.position, before.last) < 2.0 * CELL else None
    if enough is not None and seen.sweep.closed and measured.all():
        return enough, ALL_SEEN
    gaps, wide = gaps_between(measured, seen.sweep.step)
    if enough is not None and len(wide) == 0:
        return enough, ALL_SEEN
    cells, first = _around(before, state.position)
    beams = (seen.origins if len(seen.origins) else np.zeros((len(seen.kind), 3))) + np.array([*state.position, 0.0])
    pairs, robot = np.cumsum(measured) - 1, (*state.position, radius)
    out = _see(cells, first, beams, seen.distance, gaps, pairs, len(wide) == 0, *seen.sweep[:2], robot)
    coverage = Coverage(cells, first, state.position)
    if len(wide) == 0:
        return coverage, ALL_SEEN
    hidden, free = out & (cells == UNKNOWN), np.pad(cells == FREE, 1)
    beside = free[2:, 1:-1] | free[:-2, 1:-1] | free[1:-1, 2:] | free[1:-1, :-2]
    places, edges = (CELL * (np.argwhere(which) + first) for which in (hidden, hidden & beside))
    widths = seen.sweep.step * (wide[:, 1] - wide[:, 0])
    middle = wide[widths.argmax()].mean() * seen.sweep.step
    faces = math.remainder(seen.sweep.first + middle + math.pi - state.yaw, math.tau)
    return coverage, Unseen(seen.stamp, places, edges, float(widths.sum()), faces)


@njit
def gaps_between(measured: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """First and last beam (m, 2) of each two neighbours that measured anything, and (g, 2) of those with some between.

    The last pair goes on over a full turn to the first beam. `measured` (n,) is whether each beam did, one at least;
    `step` is the angle from beam to beam [rad].
    """
    beams = np.flatnonzero(measured).astype(np.float64)
    gaps = np.column_stack((beams, np.append(beams[1:], beams[0] + math.tau / step)))
    apart = gaps[:, 1] - gaps[:, 0]
    return gaps, gaps[(apart > NEXT) & (apart * step * REACH > NARROW)]


def blind_angle(scan: Scan) -> float:
    """Angle that a scan leaves out, or in which it measured nothing, all gaps wide enough together [rad]."""
    step, measured = abs(scan.angle_increment), ~np.isnan(scan.ranges)
    if not measured.any():
        return math.tau
    _, wide = gaps_between(measured, step)
    return float(step * (wide[:, 1] - wide[:, 0]).sum())


def _around(before: Coverage | None, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cells to be written to and the first of them, with the robot far enough from their edge."""
    middle, n = np.floor(position / CELL + 0.5).astype(int), 2 * HALF + 1
    if before is None:
        return np.zeros((n, n), np.uint8), middle - HALF
    shift = middle - HALF - before.first
    if (np.abs(shift) <= HALF - REACH / CELL - 1).all():
        return before.cells.copy(), before.first
    cells = np.zeros((n, n), np.uint8)
    old, new = (tuple(slice(max(sign * s, 0), n + min(sign * s, 0)) for s in shift.tolist()) for sign in (1, -1))
    cells[new] = before.cells[old]
    return cells, middle - HALF


@njit
def _is_behind(
    x: float, y: float, beams: np.ndarray, ranges: np.ndarray, bearing: float, step: float, spread: np.ndarray
) -> bool:
    """Returns whether a block around a point is behind what every beam near to it met; `spread` is of `_spread`."""
    off, turn, more = spread
    away, size = math.hypot(x - beams[0, 0], y - beams[0, 1]) - off, CELL * BLOCK * math.sqrt(0.5)
    if away <= size + 2.0 * off:
        return False
    around = (math.asin((size + 2.0 * off) / away) + turn) / step + more
    place, farthest = place_towards(x, y, beams, bearing, step, 0), 0.0
    for k in range(int(place - around), int(place + around) + 1):
        farthest = max(farthest, ranges[k % len(ranges)])
    return farthest < away - size - BEHIND * CELL


@njit
def _spread(beams: np.ndarray, gaps: np.ndarray, step: float) -> np.ndarray:
    """How far the beams begin apart [m], how much they turn [rad], and how far off a pair may be [beams]."""
    off, turn = np.hypot(beams[:, 0] - beams[0, 0], beams[:, 1] - beams[0, 1]).max(), np.ptp(beams[:, 2])
    return np.array([off, turn, (gaps[:, 1] - gaps[:, 0]).max() + abs(2.0 * math.pi / step - len(beams)) + 2.0])


@njit
def _see(  # noqa: PLR0913
    cells: np.ndarray,
    first: np.ndarray,
    beams: np.ndarray,
    ranges: np.ndarray,
    gaps: np.ndarray,
    pairs: np.ndarray,
    all_round: bool,
    bearing: float,
    step: float,
    robot: tuple[float, float, float],
) -> np.ndarray:
    """Notes what a scan sees in the cells, and returns which of those not known to be free it has out of view."""
    x, y, radius = robot
    n, reach, out, spread = len(beams), int(REACH / CELL), np.zeros(cells.shape, np.bool_), _spread(beams, gaps, step)
    i0, j0 = int(round(x / CELL)) - reach, int(round(y / CELL)) - reach
    for i in range(i0, i0 + 2 * reach + 1, BLOCK):
        for j in range(j0, j0 + 2 * reach + 1, BLOCK):
            u, v = CELL * (i + 0.5 * (BLOCK - 1)), CELL * (j + 0.5 * (BLOCK - 1))
            beside = math.hypot(u - x, v - y) > radius + CELL * BLOCK
            if all_round and beside and _is_behind(u, v, beams, ranges, bearing, step, spread):
                continue
            for a in range(i, min(i + BLOCK, i0 + 2 * reach + 1)):
                for b in range(j, min(j + BLOCK, j0 + 2 * reach + 1)):
                    row, column = a - first[0], b - first[1]
                    if cells[row, column] == FREE:
                        continue
                    away = math.hypot(a * CELL - x, b * CELL - y)
                    if away < radius:
                        cells[row, column] = FREE
                    if away > REACH:
                        continue
                    place = place_towards(a * CELL, b * CELL, beams, bearing, step, 0)
                    k = pairs[min(int(place), n - 1)]
                    if k < 0:
                        k, place = len(gaps) - 1, place + 2.0 * math.pi / step
                    before, after = int(gaps[k, 0]), int(gaps[(k + 1) % len(gaps), 0])
                    nearest = min(before if place - gaps[k, 0] < gaps[k, 1] - place else after, n - 1)
                    away = math.hypot(a * CELL - beams[nearest, 0], b * CELL - beams[nearest, 1])
                    apart = gaps[k, 1] - gaps[k, 0]
                    if apart > NEXT and apart * step * away > NARROW:
                        out[row, column] = True
                    elif away <= min(ranges[before], ranges[after]):
                        cells[row, column] = FREE
                    elif away <= max(ranges[before], ranges[after]) + BEHIND * CELL:
                        cells[row, column] = max(cells[row, column], SOLID)
    return out
