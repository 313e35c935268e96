"""Walls cut into short pieces, at the same places in every scan."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.time_to_goal_planner.boundary_memory.working import Cuts, Sight


class _Stretch(NamedTuple):
    """Visible part of a wall."""

    low: float  # low, high: shares of the wall between which it is seen
    high: float
    before: float  # before, beyond: lengths over which its surface is seen before and beyond the wall, along it [m]
    beyond: float


@njit
def _visible(wall: np.ndarray, sight: Sight) -> tuple[float, float]:
    """Shares of a wall between which it lies in the square that counts; 1, 0 if nowhere. Liang and Barsky 1984."""
    low, high = 0.0, 1.0
    for begin, rise in ((wall[0] - sight.x, wall[2] - wall[0]), (wall[1] - sight.y, wall[3] - wall[1])):
        if rise == 0.0:
            if abs(begin) > sight.half_side:
                return 1.0, 0.0
        else:
            enter, leave = (-sight.half_side - begin) / rise, (sight.half_side - begin) / rise
            low, high = max(low, min(enter, leave)), min(high, max(enter, leave))
    return (low, high) if low <= high else (1.0, 0.0)


@njit
def _linked(walls: np.ndarray, owner: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """(w,) the wall that each goes on from without a break, -1 where what is seen of a surface begins with it."""
    n = len(walls)
    linked = np.full(n, -1, np.int64)
    first = 0
    for i in range(n):
        if owner[i] != owner[first]:
            first = i
        if i > first and shares[i - 1, 1] == 1.0 and shares[i, 0] == 0.0:
            linked[i] = i - 1
        closes = i > first and walls[i, 2] == walls[first, 0] and walls[i, 3] == walls[first, 1]
        last = i == n - 1 or owner[i + 1] != owner[i]
        if closes and last and shares[i, 1] == 1.0 and shares[first, 0] == 0.0:
            linked[first] = i
    return linked


@njit
def _seen_beside(linked: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(w,) how far a surface is seen before and beyond each of its walls, along it [m]."""
    n = len(linked)
    before, beyond = np.zeros(n), np.zeros(n)
    for _ in range(2):  # again for a surface that closes
        for i in range(n):
            if linked[i] >= 0:
                before[i] = before[linked[i]] + lengths[linked[i]]
        for i in range(n - 1, -1, -1):
            if linked[i] >= 0:
                beyond[linked[i]] = beyond[i] + lengths[i]
    return before, beyond


@njit
def _is_single_gap(wall: np.ndarray, sight: Sight) -> bool:
    """Returns whether no beam fell between the ends of a wall, so that no third beam confirms it."""
    ax, ay, bx, by = wall[0] - sight.x, wall[1] - sight.y, wall[2] - sight.x, wall[3] - sight.y
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by)) < 1.5 * sight.step


@njit
def _corner_cuts(walls: np.ndarray, linked: np.ndarray, widest: float, sight: Sight) -> np.ndarray:
    """(w,) whether a wall is a cut across a corner, or a jump to what is behind: a single gap beside sure walls."""
    n = len(walls)
    single = np.zeros(n, np.bool_)
    for i in range(n):
        length = math.sqrt((walls[i, 2] - walls[i, 0]) ** 2 + (walls[i, 3] - walls[i, 1]) ** 2)
        single[i] = length <= widest and _is_single_gap(walls[i], sight)
    beside_sure, beside_single = np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    for i in range(n):
        j = linked[i]
        if j >= 0:
            beside_sure[i], beside_single[i] = beside_sure[i] or not single[j], beside_single[i] or single[j]
            beside_sure[j], beside_single[j] = beside_sure[j] or not single[i], beside_single[j] or single[i]
    return single & beside_sure & ~beside_single


@njit
def _cores(wall: np.ndarray, low: float, high: float, length: float, spacing: float) -> np.ndarray:
    """(k, 2) where pieces of a wall begin and end along it [m]: at multiples of spacing in its longer coordinate."""
    dx, dy = wall[2] - wall[0], wall[3] - wall[1]
    begin, rise = (wall[0], dx) if abs(dx) >= abs(dy) else (wall[1], dy)
    if length < 1e-9 or rise == 0.0:
        return np.zeros((1, 2))
    first = math.floor(min(begin + low * rise, begin + high * rise) / spacing)
    last = math.floor(max(begin + low * rise, begin + high * rise) / spacing)
    cores, count = np.empty((int(last - first) + 1, 2)), 0
    for i in range(len(cores)):
        a, b = ((first + i) * spacing - begin) / rise, ((first + i + 1) * spacing - begin) / rise
        cores[count, 0], cores[count, 1] = max(min(a, b), low) * length, min(max(a, b), high) * length
        if cores[count, 1] - cores[count, 0] > 1e-9:
            count += 1
    return cores[:count]


@njit
def _normal(wall: np.ndarray, length: float, sight: Sight) -> tuple[float, float]:
    """Unit normal of a wall toward the robot; of a single point the direction to it."""
    tx, ty = sight.x - wall[0], sight.y - wall[1]
    if length < 1e-9:
        far = math.sqrt(tx * tx + ty * ty)
        return (tx / far, ty / far) if far > 1e-9 else (1.0, 0.0)
    nx, ny = (wall[1] - wall[3]) / length, (wall[2] - wall[0]) / length
    return (nx, ny) if nx * tx + ny * ty >= 0.0 else (-nx, -ny)


@njit
def _cut_wall(
    wall: np.ndarray, stretch: _Stretch, spacing: float, inset: float, sight: Sight, cuts: Cuts, k: int
) -> int:
    """Cuts what is seen of a wall into pieces number k and on; the count of pieces after it."""
    # Pieces reach over their neighbours by half a spacing. Those that this takes out of the square are left to a later
    # scan: the end of what is seen would else move along with the robot.
    low, high, before, beyond = stretch
    length = math.sqrt((wall[2] - wall[0]) ** 2 + (wall[3] - wall[1]) ** 2)
    nx, ny = _normal(wall, length, sight)
    for a, b in _cores(wall, low, high, length, spacing):
        s, e = a - 0.5 * spacing, b + 0.5 * spacing
        if (low > 0.0 and s < low * length) or (high < 1.0 and e > high * length):
            continue
        s, e = (max(0.0, s) / length, min(length, e) / length) if length > 0.0 else (0.0, 1.0)
        cuts.pieces[k, 0], cuts.pieces[k, 1] = _on(wall, s)
        cuts.pieces[k, 2], cuts.pieces[k, 3] = _on(wall, e)
        cuts.normals[k, 0], cuts.normals[k, 1] = nx, ny
        cuts.inner[k] = min(before + a - low * length, beyond + high * length - b) >= inset - 1e-9
        k += 1
    return k


@njit
def _on(wall: np.ndarray, share: float) -> tuple[float, float]:
    if share == 1.0:
        return wall[2], wall[3]
    return wall[0] + share * (wall[2] - wall[0]), wall[1] + share * (wall[3] - wall[1])


@njit
def cut(walls: np.ndarray, owner: np.ndarray, sight: Sight, spacing: float, inset: float, widest: float) -> Cuts:
    """Cuts the walls (w, 4) of surfaces `owner` (w,) that are seen in the square around the robot.

    Args:
        spacing: length of a piece [m].
        inset: distance of the inner pieces from both visible ends of their surface, around corners too [m].
        widest: cuts across a corner up to this are left out [m].
    """
    n = len(walls)
    shares, lengths = np.empty((n, 2)), np.zeros(n)
    most = 0
    for i in range(n):
        shares[i, 0], shares[i, 1] = _visible(walls[i], sight)
        length = math.sqrt((walls[i, 2] - walls[i, 0]) ** 2 + (walls[i, 3] - walls[i, 1]) ** 2)
        lengths[i] = max(0.0, shares[i, 1] - shares[i, 0]) * length
        most += int(lengths[i] / spacing) + 3
    linked = _linked(walls, owner, shares)
    before, beyond = _seen_beside(linked, lengths)
    left_out = _corner_cuts(walls, linked, widest, sight)
    cuts = Cuts(np.empty((most, 4)), np.empty((most, 2)), np.empty(most, np.bool_))
    k = 0
    for i in range(n):
        if shares[i, 0] <= shares[i, 1] and not left_out[i]:
            stretch = _Stretch(shares[i, 0], shares[i, 1], before[i], beyond[i])
            k = _cut_wall(walls[i], stretch, spacing, inset, sight, cuts, k)
    return Cuts(cuts.pieces[:k], cuts.normals[:k], cuts.inner[:k])
