"""A queue of cells by length, in buckets: those in the same bucket come in any order.

What is added lies less than a diagonal step between cells ahead of what was taken last. So a ring of buckets is enough.
"""

import numpy as np

from collplan_core.jit import njit

PER_CELL = 16
"""Buckets in the spacing of the cells: lengths are exact to this part of it."""
RING = 64
"""Buckets; what lies further ahead than so many is put into the last."""
EMPTY = -1


@njit
def push(
    heads: np.ndarray,
    below: np.ndarray,
    keys: np.ndarray,
    items: np.ndarray,
    count: int,
    now: int,
    key: float,
    item: int,
) -> int:
    """Adds entry number count, an item by its key.

    Args:
        heads: (RING,) number of each bucket's uppermost entry or EMPTY.
        below, keys, items: next entry in the bucket, key and item of each entry, by its number.
        now: the bucket taken from last, counted from key 0.
        key: key of the item [buckets].

    Returns:
        the number of entries ever added.
    """
    bucket = min(max(int(key), now), now + RING - 1) % RING
    keys[count], items[count], below[count] = key, item, heads[bucket]
    heads[bucket] = count
    return count + 1


@njit
def first_bucket(heads: np.ndarray, now: int) -> int:
    """The next bucket, counted from key 0, that holds anything; something must be left."""
    while heads[now % RING] == EMPTY:
        now += 1
    return now
