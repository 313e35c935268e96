"""Lengths of the shortest any-angle paths, spreading from the goal over the cells."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at
from collplan_core.time_to_goal_planner.shortest_paths.grid import Cells

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
    """Adds entry number count, an item by its key [buckets]; returns the number of entries ever added.

    Args:
        heads: (RING,) number of each bucket's uppermost entry or EMPTY.
        below, keys, items: next entry in the bucket, key and item of each entry, by its number.
        now: the bucket taken from last, counted from key 0.
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


CORNER_CUT = 0.0025
"""A line may cut a rounded corner by so much: what the line between two neighbouring free cells can cut [m]."""
SHORTEST_STEP = 0.02
"""Along a boundary the line is looked at in steps of this length [m]."""


@njit
def sees(cells: Cells, a: int, b: int) -> bool:
    """Returns whether the line from cell a to cell b (flat indices) is free.

    Nothing is nearer than its clearance, so as much of the line is stepped over.
    """
    my = cells.blocked.shape[1]
    x, y = cells.x + (a // my) * cells.spacing, cells.y + (a % my) * cells.spacing
    dx, dy = (b // my - a // my) * cells.spacing, (b % my - a % my) * cells.spacing
    distance = math.hypot(dx, dy)
    along = 0.0
    while along < distance:
        share = along / distance
        clearance = clearance_at(cells.clearance, cells.grid, x + share * dx, y + share * dy)
        if clearance < -CORNER_CUT:
            return False
        along += max(clearance, SHORTEST_STEP)
    return True


UNSEEN, SEEN, DONE = 0, 1, 2
"""States of a cell: whether the line to its parent was checked, and whether its length is final."""
WORTH_A_TURN = 0.2
"""A path turns in the open only where this saves so much over turning where the paths beside it do [cells]."""
MOST_ENTRIES = 16
"""In the queue by cell: each of its eight neighbours adds it once at most, and a line that is not free once more."""


class Front(NamedTuple):
    """The search, by flat index of a cell, changed in place. Lengths are counted in cells."""

    length: np.ndarray  # (n,) length of the path
    parent: np.ndarray  # (n,) int32, cell it leads to in a straight line
    state: np.ndarray  # (n,) uint8
    order: np.ndarray  # (n,) int32, the cells that are done, in that order
    heads: np.ndarray  # heads, below, keys, items: the queue of those to come
    below: np.ndarray
    keys: np.ndarray
    items: np.ndarray


def front_over(n: int) -> Front:
    """A search over n cells that has not begun."""
    entries = MOST_ENTRIES * n
    return Front(
        np.full(n, np.inf),
        np.full(n, -1, dtype=np.int32),
        np.zeros(n, dtype=np.uint8),
        np.empty(n, dtype=np.int32),
        np.full(RING, EMPTY, dtype=np.int32),
        np.empty(entries, dtype=np.int32),
        np.empty(entries),
        np.empty(entries, dtype=np.int32),
    )


@njit
def _leads(parent: np.ndarray, state: np.ndarray, cell: int, w: int) -> bool:
    return cell == w or (state[cell] == DONE and parent[cell] == w)


@njit
def _between(parent: np.ndarray, state: np.ndarray, cell: int, w: int, my: int) -> bool:
    """Whether both neighbours between which the line to w leaves the cell have w as parent: the cell sees w as well."""
    # Nothing known is thin enough to stand between two lines a cell apart.
    i, j = cell // my, cell % my
    di, dj = w // my - i, w % my - j
    si, sj = int(di > 0) - int(di < 0), int(dj > 0) - int(dj < 0)
    diagonal = (i + si) * my + j + sj
    if not _leads(parent, state, diagonal, w):
        return False
    if si == 0 or sj == 0 or abs(di) == abs(dj):
        return True
    return _leads(parent, state, (i + si) * my + j if abs(di) > abs(dj) else i * my + j + sj, w)


@njit
def _total(front: Front, my: int, i: int, j: int, w: int) -> float:
    """Length of the path from cell [i, j] by w."""
    return float(front.length[w] + math.sqrt((w // my - i) ** 2 + (w % my - j) ** 2))


@njit
def _reparent(cells: Cells, front: Front, cell: int) -> None:
    """Gives a cell a parent that it sees: that of a neighbour or a neighbour itself."""
    mx, my = cells.blocked.shape
    i, j, w = cell // my, cell % my, front.parent[cell]
    best, chosen = np.inf, -1
    for a in range(max(i - 1, 0), min(i + 2, mx)):
        for b in range(max(j - 1, 0), min(j + 2, my)):
            neighbour = a * my + b
            if front.state[neighbour] == DONE:
                total = _total(front, my, i, j, neighbour) + WORTH_A_TURN
                if total < best:
                    best, chosen = total, neighbour
    for a in range(max(i - 1, 0), min(i + 2, mx)):
        for b in range(max(j - 1, 0), min(j + 2, my)):
            neighbour = a * my + b
            other = front.parent[neighbour]
            if front.state[neighbour] == DONE and other != w and other != chosen:
                total = _total(front, my, i, j, other)
                if total < best and sees(cells, cell, other):
                    best, chosen = total, other
    front.parent[cell], front.length[cell], front.state[cell] = chosen, _total(front, my, i, j, chosen), SEEN


@njit
def _begin(cells: Cells, front: Front, goal: int, reach: float) -> int:
    """Puts the goal at the front or, where it is blocked, the free cells within reach of it; the queue's count."""
    mx, my = cells.blocked.shape
    gi, gj, count = goal // my, goal % my, 0
    most = int(reach) if cells.blocked[gi, gj] else 0
    for i in range(max(gi - most, 0), min(gi + most + 1, mx)):
        for j in range(max(gj - most, 0), min(gj + most + 1, my)):
            away = math.sqrt((i - gi) ** 2 + (j - gj) ** 2)
            if away <= reach and not cells.blocked[i, j]:
                cell = i * my + j
                front.length[cell], front.parent[cell], front.state[cell] = away, goal, SEEN
                key = away * PER_CELL
                count = push(front.heads, front.below, front.keys, front.items, count, 0, key, cell)
    front.length[goal] = 0.0 if count else np.inf
    return count


@njit
def spread(cells: Cells, front: Front, goal: int, reach: float) -> int:
    """Spreads the front from the goal's cell as far as it goes; returns the number of cells that have a path.

    `reach` is the distance that counts as arrived [cells].
    """
    # in one loop over arrays: to call something with all of them at every cell takes as long as all the rest
    mx, my = cells.blocked.shape
    blocked = cells.blocked
    length, parent, state, order, heads, below, keys, items = front
    count, taken, now, done = _begin(cells, front, goal, reach), 0, 0, 0
    while taken < count:
        now = first_bucket(heads, now)
        entry = heads[now % RING]
        heads[now % RING] = below[entry]
        taken += 1
        cell = items[entry]
        if state[cell] == DONE or keys[entry] != length[cell] * PER_CELL:
            continue
        w = parent[cell]
        if state[cell] == UNSEEN and not _between(parent, state, cell, w, my) and not sees(cells, cell, w):
            _reparent(cells, front, cell)
            count = push(heads, below, keys, items, count, now, length[cell] * PER_CELL, cell)
            continue
        state[cell] = DONE
        order[done] = cell
        done += 1
        i, j, wi, wj, behind = cell // my, cell % my, w // my, w % my, length[w]
        for a in range(max(i - 1, 0), min(i + 2, mx)):
            for b in range(max(j - 1, 0), min(j + 2, my)):
                neighbour = a * my + b
                if state[neighbour] != DONE and not blocked[a, b] and parent[neighbour] != w:
                    total = behind + math.sqrt((wi - a) ** 2 + (wj - b) ** 2)
                    if total < length[neighbour]:
                        length[neighbour], parent[neighbour], state[neighbour] = total, w, UNSEEN
                        count = push(heads, below, keys, items, count, now, total * PER_CELL, neighbour)
    return done
