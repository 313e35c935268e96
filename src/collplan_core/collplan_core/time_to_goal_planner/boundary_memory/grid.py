"""Grid of the nodes: where they lie, and how it moves along with the robot."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import inside
from collplan_core.parameters import Remembered
from collplan_core.time_to_goal_planner.boundary_memory.clearance import FAR, NOTHING, OBSERVED, Grid
from collplan_core.time_to_goal_planner.boundary_memory.record import RememberedBoundaries
from collplan_core.time_to_goal_planner.boundary_memory.working import Nodes

EDGE = 1.2
"""The grid moves before the robot is this near to its edge [m]; a quarter of its side where that is less."""


def empty_nodes(center: np.ndarray, half: float, spacing: float, radius: float) -> Nodes:
    """A square of nodes at multiples of the spacing, at least `half` to each side of the one nearest to the centre."""
    beside = math.ceil(half / spacing - 1e-9)
    n = 2 * beside + 1
    ox, oy = ((math.floor(c / spacing + 0.5) - beside) * spacing for c in center)
    clearance, source = np.full((n, n), FAR), np.full((n, n), NOTHING, np.int8)
    free, stale = np.zeros((n, n), bool), np.ones((n, n), bool)
    return Nodes(clearance, source, free, stale, Grid(ox, oy, spacing), radius)


def nodes_around(memory: RememberedBoundaries, position: np.ndarray, radius: float, settings: Remembered) -> Nodes:
    """A copy of the remembered grid; from another origin on, and stale where it is new, if the robot nears its edge."""
    field, side = memory.field, settings.side
    edge = min(EDGE, 0.25 * side)
    last = field.origin + (len(field.clearance) - 1) * field.spacing
    if (position - field.origin > edge).all() and (last - position > edge).all():
        grids = field.clearance.copy(), field.source.copy(), memory.free.copy(), np.zeros_like(memory.free)
        return Nodes(*grids, field.grid, radius)
    nodes = empty_nodes(position, 0.5 * side, settings.spacing, radius)
    _carry_over(nodes, field.clearance, field.source, memory.free, field.grid)
    return nodes


@njit
def _carry_over(nodes: Nodes, clearance: np.ndarray, source: np.ndarray, free: np.ndarray, grid: Grid) -> None:
    """Copies what an earlier grid holds to the nodes at the same places."""
    si = int(round((nodes.grid.x - grid.x) / nodes.grid.spacing))
    sj = int(round((nodes.grid.y - grid.y) / nodes.grid.spacing))
    n, (nx, ny) = len(nodes.free), free.shape
    for i in range(max(0, -si), min(n, nx - si)):
        for j in range(max(0, -sj), min(n, ny - sj)):
            nodes.clearance[i, j], nodes.source[i, j] = clearance[i + si, j + sj], source[i + si, j + sj]
            nodes.free[i, j], nodes.stale[i, j] = free[i + si, j + sj], False


@njit
def window(nodes: Nodes, x0: float, y0: float, x1: float, y1: float, reach: float) -> tuple[int, int, int, int]:
    """Nodes in the box that reaches beyond a piece: first and one past the last, in x and in y."""
    (nx, ny), grid = nodes.free.shape, nodes.grid
    return (
        max(0, int(math.ceil((min(x0, x1) - reach - grid.x) / grid.spacing))),
        min(nx, int(math.floor((max(x0, x1) + reach - grid.x) / grid.spacing)) + 1),
        max(0, int(math.ceil((min(y0, y1) - reach - grid.y) / grid.spacing))),
        min(ny, int(math.floor((max(y0, y1) + reach - grid.y) / grid.spacing)) + 1),
    )


@njit
def see_free(nodes: Nodes, ends: np.ndarray, x: float, y: float, half_side: float) -> None:
    """Note where the centre is free by F, its ends relative to (x, y), and where a boundary now blocks it."""
    i0, i1, j0, j1 = window(nodes, x, y, x, y, half_side + nodes.radius)
    grid = nodes.grid
    for i in range(i0, i1):
        for j in range(j0, j1):
            if nodes.clearance[i, j] < 0.0 and nodes.source[i, j] == OBSERVED:
                nodes.free[i, j] = False
            elif not nodes.free[i, j]:
                nodes.free[i, j] = inside(ends, grid.x + i * grid.spacing - x, grid.y + j * grid.spacing - y)
