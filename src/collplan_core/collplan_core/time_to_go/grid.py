"""The cells over which shortest paths are searched."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.remembered.clearance import FAR, ClearanceField, clearance_at

PADDING = 0.3
"""Free space around everything known [m]."""
MOST_CELLS = 60_000


@njit
def _known_box(clearance: np.ndarray) -> tuple[int, int, int, int]:
    """First and last node by axis at which anything is near; first > last where nothing is."""
    nx, ny = clearance.shape
    i0, i1, j0, j1 = nx, -1, ny, -1
    for i in range(nx):
        for j in range(ny):
            if clearance[i, j] < FAR:
                i0, i1 = min(i0, i), i
                j0, j1 = min(j0, j), max(j1, j)
    return i0, i1, j0, j1


def cells_around(field: ClearanceField, goal: np.ndarray, around: np.ndarray, spacing: float,
                 ) -> tuple[np.ndarray, np.ndarray, float]:  # fmt: skip
    """Cells that cover everything known, the goal and around.

    The goal is a cell's centre: where all is turned about the goal by a right angle, cells turn into cells.

    Returns:
        first (2,) and last (2,) cell counted from the goal's; spacing [m], more than asked for where there would be
        more than 60,000 cells.
    """
    i0, i1, j0, j1 = _known_box(field.clearance)
    points = [goal, around]
    if i0 <= i1:
        points += [field.origin + field.spacing * np.array(node) for node in ((i0, j0), (i1, j1))]
    low, high = np.min(points, axis=0) - PADDING - goal, np.max(points, axis=0) + PADDING - goal
    spacing = max(spacing, math.sqrt(float(np.prod(high - low)) / MOST_CELLS))
    return np.floor(low / spacing).astype(int), np.ceil(high / spacing).astype(int), spacing


@njit
def blocked_cells(clearance: np.ndarray, ox: float, oy: float, field_spacing: float, x0: float, y0: float,
                  spacing: float, mx: int, my: int) -> np.ndarray:  # fmt: skip
    """(mx, my) bool, cells at whose centre the disc would touch.

    A free strip as wide as a cell always holds a chain of neighbouring centres, however it is turned; a blocked band
    of 1.5 cells always parts them.
    """
    blocked = np.empty((mx, my), dtype=np.bool_)
    for i in range(mx):
        for j in range(my):
            near = clearance_at(clearance, ox, oy, field_spacing, x0 + i * spacing, y0 + j * spacing)
            blocked[i, j] = near < 0.0
    return blocked
