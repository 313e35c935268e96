"""The clearance field as pieces come and go: the minimum over all of them, whatever their order."""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.remembered.clearance import FAR, INFERRED, OBSERVED

# so little more than a square of a distance is told from it by its root as well
GUARD = 1.0 + 1e-12


@njit
def inferred_rows(depth: float, radius: float) -> np.ndarray:
    """How far behind a piece there are inferred ones [m]: discs around them leave no hole down to `depth`."""
    deepest = depth - 2.0 * radius
    if deepest <= 0.0:
        return np.zeros(0)
    n = max(1, int(math.ceil(deepest / (1.5 * radius) - 1e-9)))
    return deepest * np.arange(1, n + 1) / n


@njit
def window(x0: float, y0: float, x1: float, y1: float, reach: float, ox: float, oy: float, spacing: float, nx: int,
           ny: int) -> tuple[int, int, int, int]:  # fmt: skip
    """Nodes within `reach` of a piece's box: first and one past the last, in x and in y."""
    return (
        max(0, int(math.ceil((min(x0, x1) - reach - ox) / spacing))),
        min(nx, int(math.floor((max(x0, x1) + reach - ox) / spacing)) + 1),
        max(0, int(math.ceil((min(y0, y1) - reach - oy) / spacing))),
        min(ny, int(math.floor((max(y0, y1) + reach - oy) / spacing)) + 1),
    )


@njit
def _lower(clearance: np.ndarray, source: np.ndarray, stale: np.ndarray, everywhere: bool, ox: float, oy: float,
           spacing: float, radius: float, x0: float, y0: float, x1: float, y1: float, what: int) -> None:  # fmt: skip
    """Lower the clearance to that from one piece; at stale nodes alone, or everywhere."""
    nx, ny = clearance.shape
    i0, i1, j0, j1 = window(x0, y0, x1, y1, radius + FAR, ox, oy, spacing, nx, ny)
    dx, dy = x1 - x0, y1 - y0
    length2 = dx * dx + dy * dy
    inverse = 1.0 / length2 if length2 > 1e-24 else 0.0
    for i in range(i0, i1):
        ax = ox + i * spacing - x0
        for j in range(j0, j1):
            if not everywhere and not stale[i, j]:
                continue
            ay = oy + j * spacing - y0
            along = min(1.0, max(0.0, (ax * dx + ay * dy) * inverse))
            ex, ey = ax - along * dx, ay - along * dy
            square = ex * ex + ey * ey
            known = clearance[i, j] + radius
            if square > known * known * GUARD:
                continue
            c = math.sqrt(square) - radius
            if c < clearance[i, j]:
                clearance[i, j], source[i, j] = c, what
            elif c == clearance[i, j] and c < FAR and what == OBSERVED:
                source[i, j] = what


@njit
def lower_by_piece(clearance: np.ndarray, source: np.ndarray, stale: np.ndarray, everywhere: bool, ox: float,
                   oy: float, spacing: float, radius: float, piece: np.ndarray) -> None:  # fmt: skip
    """Lower the clearance to that from an observed piece."""
    _lower(clearance, source, stale, everywhere, ox, oy, spacing, radius,
           piece[0], piece[1], piece[2], piece[3], OBSERVED)  # fmt: skip


@njit
def lower_behind_piece(clearance: np.ndarray, source: np.ndarray, stale: np.ndarray, everywhere: bool, ox: float,
                       oy: float, spacing: float, radius: float, piece: np.ndarray, normal: np.ndarray,
                       rows: np.ndarray) -> None:  # fmt: skip
    """Lower the clearance to that from what is inferred behind a piece."""
    for row in rows:
        sx, sy = -row * normal[0], -row * normal[1]
        _lower(clearance, source, stale, everywhere, ox, oy, spacing, radius,
               piece[0] + sx, piece[1] + sy, piece[2] + sx, piece[3] + sy, INFERRED)  # fmt: skip


@njit
def make_stale(stale: np.ndarray, ox: float, oy: float, spacing: float, radius: float, piece: np.ndarray,
               normal: np.ndarray, deepest: float) -> None:  # fmt: skip
    """Mark the nodes that a piece, and what is inferred behind it down to `deepest`, can have lowered."""
    nx, ny = stale.shape
    reach = radius + FAR
    for shift in (0.0, deepest):
        sx, sy = -shift * normal[0], -shift * normal[1]
        i0, i1, j0, j1 = window(
            piece[0] + sx, piece[1] + sy, piece[2] + sx, piece[3] + sy, reach, ox, oy, spacing, nx, ny
        )
        stale[i0:i1, j0:j1] = True
