"""Clearance of the disc's centre from remembered boundaries: a field on a grid, read between its nodes."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit

FAR = 0.10
"""Largest clearance in the field, where nothing is nearer [m]."""
NOTHING, OBSERVED, PENDING, INFERRED = 0, 1, 2, 3
"""Kind of the nearest boundary of a node; of equally near ones the lesser kind counts. What is in sight, but not for
long enough to stand, is pending; out of sight it will not stand soon, and counts as inferred."""


class Grid(NamedTuple):
    """Square nodes in the world frame: [i, j] lies at (x, y) + spacing * (i, j) [m]."""

    x: float
    y: float
    spacing: float


@dataclass(frozen=True, eq=False)
class ClearanceField:
    """Clearance of the disc's centre from boundaries, world frame. Outside of the grid nothing is known: FAR."""

    origin: np.ndarray  # (2,) where node [0, 0] is [m]
    spacing: float  # distance between neighbouring nodes [m]
    clearance: np.ndarray
    """(nx, ny) distance to the nearest boundary less the disc's radius, below 0 inside, at most FAR [m]."""
    source: np.ndarray  # (nx, ny) int8, kind of that boundary: NOTHING, OBSERVED, PENDING or INFERRED

    @property
    def grid(self) -> Grid:
        """Grid of the nodes, for compiled code."""
        return Grid(float(self.origin[0]), float(self.origin[1]), self.spacing)

    def known(self) -> np.ndarray:
        """(2, 2) corners of the box around the nodes that anything is near to [m]; (0, 2) where there are none."""
        i0, i1, j0, j1 = _known_nodes(self.clearance)
        return self.origin + self.spacing * np.array([(i0, j0), (i1, j1)]) if i0 <= i1 else np.zeros((0, 2))


@njit
def _known_nodes(clearance: np.ndarray) -> tuple[int, int, int, int]:
    """First and last node by axis at which anything is near; first > last where nothing is."""
    nx, ny = clearance.shape
    i0, i1, j0, j1 = nx, -1, ny, -1
    for i in range(nx):
        for j in range(ny):
            if clearance[i, j] < FAR:
                i0, i1 = min(i0, i), i
                j0, j1 = min(j0, j), max(j1, j)
    return i0, i1, j0, j1


@njit
def nearest_node(grid: Grid, x: float, y: float) -> tuple[int, int]:
    """The node nearest to (x, y), which may lie beyond the grid."""
    return int(math.floor((x - grid.x) / grid.spacing + 0.5)), int(math.floor((y - grid.y) / grid.spacing + 0.5))


@njit
def clearance_at(clearance: np.ndarray, grid: Grid, x: float, y: float) -> float:
    """Clearance at (x, y), linear between the nodes [m]."""
    # the same for every call in a loop: taken out of it
    scale = 1.0 / grid.spacing
    fx, fy = (x - grid.x) * scale, (y - grid.y) * scale
    nx, ny = clearance.shape
    if not (0.0 <= fx < nx - 1 and 0.0 <= fy < ny - 1):
        return FAR
    i, j = int(fx), int(fy)
    a, b = fx - i, fy - j
    return (1.0 - a) * ((1.0 - b) * clearance[i, j] + b * clearance[i, j + 1]) + a * (
        (1.0 - b) * clearance[i + 1, j] + b * clearance[i + 1, j + 1]
    )


@njit
def normal_at(clearance: np.ndarray, grid: Grid, x: float, y: float) -> tuple[float, float]:
    """Unit direction in which the clearance at (x, y) grows: out of the boundary; (0, 0) where it is level.

    Over half a spacing to each side: the slope within a cell is that of its middle, wherever in it the place is.
    """
    h = 0.5 * grid.spacing
    rise_x = clearance_at(clearance, grid, x + h, y) - clearance_at(clearance, grid, x - h, y)
    rise_y = clearance_at(clearance, grid, x, y + h) - clearance_at(clearance, grid, x, y - h)
    length = math.hypot(rise_x, rise_y)
    return (rise_x / length, rise_y / length) if length > 1e-12 else (0.0, 0.0)


@njit
def source_at(source: np.ndarray, grid: Grid, x: float, y: float) -> int:
    """Returns the kind of the boundary nearest to (x, y): that of the nearest node."""
    i, j = nearest_node(grid, x, y)
    nx, ny = source.shape
    return int(source[i, j]) if 0 <= i < nx and 0 <= j < ny else NOTHING
