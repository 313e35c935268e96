"""Complement of rectangles in a square, as rectangles: solid around free ones, free space beside solid ones."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np


def largest_rectangles_beside(rectangles: np.ndarray, side: float) -> np.ndarray:
    """Every largest rectangle of [0, side]^2 outside of `rectangles` (n, 4) x0, y0, x1, y1: (m, 4) [m].

    They overlap, so that each face of what is left is the edge of one of them, without a seam.
    """
    xs = np.unique([0.0, side, *rectangles[:, [0, 2]].ravel()])
    ys = np.unique([0.0, side, *rectangles[:, [1, 3]].ravel()])
    left = _cells_left(rectangles, xs, ys)
    blocks = list(_blocks(left))
    largest = [block for block in blocks if not any(_within(block, other) for other in blocks if other != block)]
    return np.array([[xs[i0], ys[j0], xs[i1], ys[j1]] for i0, j0, i1, j1 in largest]).reshape(-1, 4)


def _cells_left(rectangles: np.ndarray, xs: np.ndarray, ys: np.ndarray) -> np.ndarray:
    """Mask of the cells between the lines xs and ys that no rectangle covers."""
    x, y = np.meshgrid((xs[:-1] + xs[1:]) / 2, (ys[:-1] + ys[1:]) / 2, indexing="ij")
    x0, y0, x1, y1 = rectangles.T[:, :, None, None]
    return ~((x0 < x) & (x < x1) & (y0 < y) & (y < y1)).any(axis=0)


def _blocks(left: np.ndarray) -> Iterator[tuple[int, int, int, int]]:
    for i0, i1 in combinations(range(left.shape[0] + 1), 2):
        for j0, j1 in combinations(range(left.shape[1] + 1), 2):
            if left[i0:i1, j0:j1].all():
                yield i0, j0, i1, j1


def _within(block: tuple[int, ...], other: tuple[int, ...]) -> bool:
    return block[0] >= other[0] and block[1] >= other[1] and block[2] <= other[2] and block[3] <= other[3]
