"""What the newest scan says against the memory: a place that it sees through is free."""

import math

import numpy as np

from collplan_core.jit import njit

EDGE_ON = 0.1
"""A piece met at a sine below this is not judged: which side of it a beam passes is the pose's noise."""
SCANS = 2
"""So many scans running must see through an observed piece."""


@njit
def seen_beyond(view: np.ndarray, sight: np.ndarray, x: float, y: float) -> float:
    """By how much both beams beside a point see farther than it; negative where one does not, or there is none [m]."""
    n = len(view)
    dx, dy = x - sight[0], y - sight[1]
    if n < 2:
        return -math.inf
    place = ((math.atan2(dy, dx) - sight[2]) % (2.0 * math.pi)) / sight[3]
    before = int(math.floor(place))
    after = before + 1
    if after >= n:
        closed = abs(n * sight[3] - 2.0 * math.pi) < 0.5 * sight[3]
        if not closed:
            return -math.inf
        before, after = before % n, after % n
    return min(view[before], view[after]) - math.hypot(dx, dy)


@njit
def sees_through(view: np.ndarray, sight: np.ndarray, half_side: float, x: float, y: float, nx: float, ny: float,
                 margin: float) -> bool:  # fmt: skip
    """Whether the scan sees farther than a piece at (x, y) of unit normal n, by `margin` square to it."""
    dx, dy = x - sight[0], y - sight[1]
    if max(abs(dx), abs(dy)) > half_side:
        return False
    far = math.hypot(dx, dy)
    square = abs(dx * nx + dy * ny)
    if square < EDGE_ON * far:
        return False
    return seen_beyond(view, sight, x, y) * square > margin * far


@njit
def refutes(view: np.ndarray, sight: np.ndarray, half_side: float, piece: np.ndarray, normal: np.ndarray,
            rows: np.ndarray, margin: float) -> bool:  # fmt: skip
    """Whether the scan sees a place that is inferred to be solid behind a piece, by `margin`."""
    x, y = 0.5 * (piece[0] + piece[2]), 0.5 * (piece[1] + piece[3])
    for row in rows:
        px, py = x - row * normal[0], y - row * normal[1]
        if max(abs(px - sight[0]), abs(py - sight[1])) <= half_side and seen_beyond(view, sight, px, py) > margin:
            return True
    return False


@njit
def judge(view: np.ndarray, sight: np.ndarray, half_side: float, margin: float, pieces: np.ndarray,
          normals: np.ndarray, backed: np.ndarray, refuted: np.ndarray, doubted: np.ndarray, kept: np.ndarray,
          rows: np.ndarray) -> None:  # fmt: skip
    """Count doubts about the pieces, let go of those doubted SCANS times running, and of inferred solid seen free."""
    for k in range(len(pieces)):
        x, y = 0.5 * (pieces[k, 0] + pieces[k, 2]), 0.5 * (pieces[k, 1] + pieces[k, 3])
        if sees_through(view, sight, half_side, x, y, normals[k, 0], normals[k, 1], margin):
            doubted[k] += 1
            kept[k] = doubted[k] < SCANS
        else:
            doubted[k] = 0
        if backed[k] and refutes(view, sight, half_side, pieces[k], normals[k], rows, margin):
            backed[k], refuted[k] = False, True
