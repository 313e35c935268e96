"""A binary heap of cells by length, in place in two arrays."""

import numpy as np

from collplan_core.jit import njit


@njit
def push(keys: np.ndarray, items: np.ndarray, count: int, key: float, item: int) -> int:
    """Adds an item; the new count."""
    k = count
    while k > 0:
        above = (k - 1) >> 1
        if keys[above] <= key:
            break
        keys[k], items[k] = keys[above], items[above]
        k = above
    keys[k], items[k] = key, item
    return count + 1


@njit
def drop_first(keys: np.ndarray, items: np.ndarray, count: int) -> int:
    """Takes the first, which has the smallest key, away; the new count."""
    count -= 1
    key, item = keys[count], items[count]
    k, below = 0, 1
    while below < count:
        if below + 1 < count and keys[below + 1] < keys[below]:
            below += 1
        if keys[below] >= key:
            break
        keys[k], items[k] = keys[below], items[below]
        k, below = below, 2 * below + 1
    keys[k], items[k] = key, item
    return count
