"""The cells over which shortest paths are searched."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import ClearanceField, Grid, clearance_at

PADDING = 0.15
"""Free space around everything known [m]."""
MOST_CELLS = 60_000
MOST_ALONG = 6_000
"""Cells along one axis: a strip thinner than a cell would have any number of them."""


class Cells(NamedTuple):
    """The cells and the clearance field under them. Cell [i, j] has its centre at (x, y) + spacing * (i, j)."""

    blocked: np.ndarray  # (mx, my) bool
    x: float  # x, y, spacing: [m]
    y: float
    spacing: float
    clearance: np.ndarray  # (nx, ny) on the nodes of `grid` [m]
    grid: Grid


def _covered(field: ClearanceField, goal: np.ndarray, around: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners, seen from the goal, of the box around everything known, goal and around [m]."""
    points = np.vstack([goal, around, field.known()])
    return np.min(points, axis=0) - PADDING - goal, np.max(points, axis=0) + PADDING - goal


def cells_around(field: ClearanceField, goal: np.ndarray, around: np.ndarray, spacing: float) -> tuple[Cells, int]:
    """Cells that cover everything known, the goal and around, and the goal's cell as flat index.

    The goal is a cell's centre: where all is turned about the goal by a right angle, cells turn into cells. Cells are
    larger than the spacing [m] where there would be more than about 60,000.
    """
    low, high = _covered(field, goal, around)
    width, height = (float(side) for side in high - low)
    spacing = max(spacing, math.sqrt(width / MOST_CELLS * height), max(width, height) / MOST_ALONG)
    first, last = np.floor(low / spacing).astype(int), np.ceil(high / spacing).astype(int)
    x, y = (float(v) for v in goal + spacing * first)
    blocked = np.empty(last - first + 1, dtype=np.bool_)
    cells = Cells(blocked, x, y, spacing, field.clearance, field.grid)
    _block(cells)
    return cells, int(-first[0] * blocked.shape[1] - first[1])


@njit
def _block(cells: Cells) -> None:
    """Blocks the cells at whose centre the disc would touch."""
    # A free strip as wide as a cell always holds a chain of neighbouring centres, however it is turned; a blocked band
    # of 1.5 cells always parts them.
    blocked, x, y, spacing, clearance, grid = cells
    mx, my = blocked.shape
    for i in range(mx):
        for j in range(my):
            blocked[i, j] = clearance_at(clearance, grid, x + i * spacing, y + j * spacing) < 0.0
