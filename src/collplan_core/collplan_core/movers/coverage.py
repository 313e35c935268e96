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


@dataclass(frozen=True, eq=False)
class Coverage:
    """What the scans so far saw, world frame.

    Attributes:
        cells: (2 HALF + 1, 2 HALF + 1) uint8, UNKNOWN, SOLID or FREE.
        first: (2,) int, cell [0, 0]: its middle is at first * CELL [m].
        last: (2,) where the robot was when a scan was added [m].
    """

    cells: np.ndarray
    first: np.ndarray
    last: np.ndarray


def with_view(before: Coverage | None, seen: SeenSurfaces, state: State, radius: float) -> tuple[Coverage, Unseen]:
    """What the scans so far saw, with one more, and what it leaves unseen.

    Args:
        before: after the scan before; None at the first.
        seen: surfaces in the scan, those of movers included: they hide what is behind them, as walls do.
        state: the robot at its stamp.
        radius: radius of the robot, which stands on what is free [m].
    """
    gaps, wide = gaps_between(seen.kind != UNSEEN, seen.sweep.step)
    if before is not None and len(wide) == 0 and math.dist(state.position, before.last) < 2.0 * CELL:
        return before, ALL_SEEN
    cells, first = _around(before, state.position)
    beams = (seen.origins if len(seen.origins) else np.zeros((len(seen.kind), 3))) + np.array([*state.position, 0.0])
    out = np.zeros(cells.shape, bool)
    _see(cells, out, first, beams, seen.distance, gaps, seen.sweep.first, seen.sweep.step, (*state.position, radius))
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


def gaps_between(measured: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """First and last beam of each pair of neighbours that measured anything, and of those with something between.

    The last pair goes on over a full turn to the first beam.

    Args:
        measured: (n,) whether each beam did; one at least.
        step: angle from beam to beam [rad].

    Returns:
        (m, 2) and (g, 2) numbers of beams.
    """
    beams = np.flatnonzero(measured).astype(float)
    gaps = np.column_stack([beams, np.append(beams[1:], beams[0] + math.tau / step)])
    apart = gaps[:, 1] - gaps[:, 0]
    return gaps, gaps[(apart > NEXT) & (apart * step * REACH > NARROW)]


def blind_angle(scan: Scan) -> float:
    """Angle that a scan leaves out, or in which it measured nothing, all gaps wide enough together [rad]."""
    step = abs(scan.angle_increment)
    _, wide = gaps_between(~np.isnan(scan.ranges), step)
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
def _see(  # noqa: PLR0913
    cells: np.ndarray,
    out: np.ndarray,
    first: np.ndarray,
    beams: np.ndarray,
    ranges: np.ndarray,
    gaps: np.ndarray,
    bearing: float,
    step: float,
    robot: tuple[float, float, float],
) -> None:
    """Notes what a scan sees in the cells, and which of them it has out of view."""
    x, y, radius = robot
    n, reach, starts = len(beams), int(REACH / CELL), gaps[:, 0].copy()
    mi, mj = int(round(x / CELL)), int(round(y / CELL))
    for i in range(mi - reach, mi + reach + 1):
        for j in range(mj - reach, mj + reach + 1):
            away = math.hypot(i * CELL - x, j * CELL - y)
            a, b = i - first[0], j - first[1]
            if away < radius:
                cells[a, b] = FREE
            if away > REACH:
                continue
            place = place_towards(i * CELL, j * CELL, beams, bearing, step, 0)
            k = np.searchsorted(starts, place, side="right") - 1
            if k < 0:
                k, place = len(gaps) - 1, place + 2.0 * math.pi / step
            before, after = int(gaps[k, 0]), int(gaps[(k + 1) % len(gaps), 0])
            nearest = min(before if place - gaps[k, 0] < gaps[k, 1] - place else after, n - 1)
            away = math.hypot(i * CELL - beams[nearest, 0], j * CELL - beams[nearest, 1])
            apart = gaps[k, 1] - gaps[k, 0]
            if apart > NEXT and apart * step * away > NARROW:
                out[a, b] = True
            elif away <= min(ranges[before], ranges[after]):
                cells[a, b] = FREE
            elif away <= max(ranges[before], ranges[after]) + BEHIND * CELL:
                cells[a, b] = max(cells[a, b], SOLID)
