"""Lengths of the shortest any-angle paths, spreading from the goal over the cells.

Dijkstra's search in which a cell's parent is any cell that it sees; the line is looked at only when the cell's turn
comes (after Lazy Theta*, Nash, Koenig and Tovey 2010).
"""

import math

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_go.heap import drop_first, push
from collplan_core.time_to_go.sight import sees

UNSEEN, SEEN, DONE = 0, 1, 2
"""Whether the line from a cell to its parent was looked at, and whether its length is final."""
MOST_ENTRIES = 16
"""In the heap by cell: each of its eight neighbours enters it once at most, and a line that is not free once more."""


@njit
def _between(i: int, j: int, wi: int, wj: int, parent: np.ndarray, state: np.ndarray, my: int) -> bool:
    """Whether the two neighbours between which the line to w leaves the cell both have w as parent.

    Then the cell sees w as well: nothing known is thin enough to stand between two lines a cell apart.
    """
    di, dj = wi - i, wj - j
    si, sj = (di > 0) - (di < 0), (dj > 0) - (dj < 0)
    w = wi * my + wj
    diagonal = (i + si) * my + j + sj
    beside = (i + si) * my + j if abs(di) > abs(dj) else i * my + j + sj
    if si == 0 or sj == 0 or abs(di) == abs(dj):
        beside = diagonal
    return _leads(diagonal, w, parent, state) and _leads(beside, w, parent, state)


@njit
def _leads(cell: int, w: int, parent: np.ndarray, state: np.ndarray) -> bool:
    return cell == w or (state[cell] == DONE and parent[cell] == w)


@njit
def spread(blocked: np.ndarray, source: int, clearance: np.ndarray, ox: float, oy: float, field_spacing: float,
           x0: float, y0: float, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:  # fmt: skip
    """Lengths and parents.

    Args:
        blocked: (mx, my) bool.
        source: flat index of the cell that all paths lead to.
        clearance: (nx, ny) of the field, its first node (ox, oy) and spacing; x0, y0, spacing of the cells.

    Returns:
        length (mx * my,) [m], inf where there is no path; parent (mx * my,) int32, the cell that the path leads to in
        a straight line, -1 without; order (mx * my,) int32 and n: the cells that have a path, from near to far.
    """
    mx, my = blocked.shape
    n = mx * my
    length, parent = np.full(n, np.inf), np.full(n, -1, dtype=np.int32)
    state, order = np.zeros(n, dtype=np.uint8), np.empty(n, dtype=np.int32)
    keys, items = np.empty(MOST_ENTRIES * n), np.empty(MOST_ENTRIES * n, dtype=np.int32)
    count, done = 0, 0
    if source >= 0:
        length[source], parent[source], state[source] = 0.0, source, SEEN
        count = push(keys, items, count, 0.0, source)
    while count > 0:
        key, cell = keys[0], items[0]
        count = drop_first(keys, items, count)
        if state[cell] == DONE or key != length[cell]:
            continue
        i, j = cell // my, cell % my
        if state[cell] == UNSEEN:
            w = parent[cell]
            wi, wj = w // my, w % my
            if not _between(i, j, wi, wj, parent, state, my) and not sees(
                clearance,
                ox,
                oy,
                field_spacing,
                x0 + wi * spacing,
                y0 + wj * spacing,
                x0 + i * spacing,
                y0 + j * spacing,
            ):
                best, chosen = np.inf, -1
                for a in range(max(i - 1, 0), min(i + 2, mx)):
                    for b in range(max(j - 1, 0), min(j + 2, my)):
                        near = a * my + b
                        if state[near] == DONE:
                            total = length[near] + spacing * math.hypot(a - i, b - j)
                            if total < best:
                                best, chosen = total, near
                for a in range(max(i - 1, 0), min(i + 2, mx)):
                    for b in range(max(j - 1, 0), min(j + 2, my)):
                        near = a * my + b
                        other = parent[near]
                        if state[near] == DONE and other != w and other != chosen:
                            oi, oj = other // my, other % my
                            total = length[other] + spacing * math.hypot(oi - i, oj - j)
                            if total < best and sees(
                                clearance, ox, oy, field_spacing,
                                x0 + oi * spacing, y0 + oj * spacing, x0 + i * spacing, y0 + j * spacing,
                            ):  # fmt: skip
                                best, chosen = total, other
                length[cell], parent[cell], state[cell] = best, chosen, SEEN
                if chosen >= 0:
                    count = push(keys, items, count, best, cell)
                continue
        state[cell] = DONE
        order[done] = cell
        done += 1
        w = parent[cell]
        wi, wj = w // my, w % my
        for a in range(max(i - 1, 0), min(i + 2, mx)):
            for b in range(max(j - 1, 0), min(j + 2, my)):
                near = a * my + b
                if state[near] == DONE or blocked[a, b]:
                    continue
                total = length[w] + spacing * math.hypot(a - wi, b - wj)
                if total < length[near]:
                    length[near], parent[near], state[near] = total, w, UNSEEN
                    count = push(keys, items, count, total, near)
    return length, parent, order, done
