"""The memory after one more scan, and the memory of a map that is given."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.free_space import inside
from collplan_core.local_map.record import LocalMap
from collplan_core.params import Remembered, Robot
from collplan_core.remembered.clearance import FAR, OBSERVED, ClearanceField
from collplan_core.remembered.contradiction import judge, refutes
from collplan_core.remembered.cutting import cut
from collplan_core.remembered.field import inferred_rows, lower_behind_piece, lower_by_piece, make_stale, window
from collplan_core.remembered.merging import bucket_of, take_up
from collplan_core.remembered.record import RememberedBoundaries

EDGE = 1.2
"""The grid moves along before the robot is nearer to its edge [m]."""
SMALLEST_BUCKET = 0.1
"""Side of the squares in which pieces are looked up [m]; five pieces where those are long."""


def remember(
    memory: RememberedBoundaries | None, local_map: LocalMap, robot: Robot, settings: Remembered
) -> RememberedBoundaries:
    """The memory with the boundaries of one more scan, without what it contradicts; the old one stays valid.

    Args:
        memory: of the scans before, None at the first one.
        local_map: of the newest scan.
    """
    nodes = 2 * round(0.5 * settings.side / settings.spacing) + 1
    if memory is None:
        memory = _nothing(local_map.position, nodes, settings.spacing)
    old = memory.field
    origin, keep = _where(old, nodes, local_map.position, settings)
    pieces, normals, backed, refuted, seen, doubted, clearance, source, free = _update(
        memory.pieces, memory.normals, memory.backed, memory.refuted, memory.seen, memory.doubted,
        old.clearance, old.source, memory.free, old.origin, origin, keep, nodes, settings.spacing,
        local_map.walls, local_map.wall_surface, local_map.view, local_map.view_from, local_map.half_side,
        local_map.ends, local_map.position, local_map.stamp, robot.radius, settings.inferred_depth,
        settings.inferred_inset, settings.contradiction, 0.5 * settings.side, settings.max_pieces,
    )  # fmt: skip
    field = ClearanceField(origin, settings.spacing, clearance, source)
    return RememberedBoundaries(pieces, normals, backed, refuted, seen, doubted, free, field)


def known_boundaries(walls: np.ndarray, center: np.ndarray, robot: Robot, settings: Remembered) -> RememberedBoundaries:
    """A memory that holds all walls (w, 4) of a given map and forgets none; free wherever nothing is touched.

    Args:
        walls: x0, y0, x1, y1 [m].
        center: (2,) of the grid, which is as large as the walls need, and at least `settings.side` [m].
    """
    walls = np.ascontiguousarray(walls, dtype=float).reshape(-1, 4)
    center = np.asarray(center, dtype=float)
    far = np.abs(walls.reshape(-1, 2) - center).max(initial=0.0) + robot.radius + FAR
    nodes = 2 * math.ceil(max(0.5 * settings.side, far) / settings.spacing) + 1
    pieces, normals, _ = cut(walls, np.arange(len(walls)), center[0], center[1], math.inf, settings.spacing, math.inf)
    no = np.zeros(len(pieces), bool)
    empty = _nothing(center, nodes, settings.spacing)
    clearance, source = empty.field.clearance, empty.field.source
    _lower_all(clearance, source, *empty.field.origin, settings.spacing, robot.radius, pieces)
    return RememberedBoundaries(
        pieces, normals, backed=no, refuted=no, seen=np.full(len(pieces), np.inf),
        doubted=np.zeros(len(pieces), np.int8), free=clearance >= 0.0,
        field=replace(empty.field, clearance=clearance, source=source),
    )  # fmt: skip


def _origin(center: np.ndarray, nodes: int, spacing: float) -> np.ndarray:
    """Of a grid whose middle node is the one nearest to the centre; nodes are multiples of the spacing."""
    return (np.floor(center / spacing + 0.5) - nodes // 2) * spacing


def _nothing(center: np.ndarray, nodes: int, spacing: float) -> RememberedBoundaries:
    field = ClearanceField(
        _origin(center, nodes, spacing), spacing, np.full((nodes, nodes), FAR), np.zeros((nodes, nodes), np.int8)
    )
    no = np.zeros(0, bool)
    return RememberedBoundaries(
        np.zeros((0, 4)), np.zeros((0, 2)), no, no, np.zeros(0), np.zeros(0, np.int8),
        np.zeros((nodes, nodes), bool), field,
    )  # fmt: skip


def _where(old: ClearanceField, nodes: int, position: np.ndarray, settings: Remembered) -> tuple[np.ndarray, bool]:
    """Origin of the grid from now on, and whether it is the old one."""
    if old.clearance.shape == (nodes, nodes) and old.spacing == settings.spacing:
        edge = min(EDGE, 0.25 * settings.side)
        size = (nodes - 1) * settings.spacing
        if ((position - old.origin > edge) & (old.origin + size - position > edge)).all():
            return old.origin, True
    return _origin(position, nodes, settings.spacing), False


@njit
def _lower_all(clearance: np.ndarray, source: np.ndarray, ox: float, oy: float, spacing: float, radius: float,
               pieces: np.ndarray) -> None:  # fmt: skip
    stale = np.zeros((1, 1), np.bool_)
    for k in range(len(pieces)):
        lower_by_piece(clearance, source, stale, True, ox, oy, spacing, radius, pieces[k])


@njit
def _moved(clearance: np.ndarray, source: np.ndarray, free: np.ndarray, old_origin: np.ndarray, origin: np.ndarray,
           nodes: int, spacing: float, stale: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:  # fmt: skip
    """The grids from another origin on; nodes that the old ones did not have are stale."""
    new_clearance = np.full((nodes, nodes), FAR)
    new_source = np.zeros((nodes, nodes), np.int8)
    new_free = np.zeros((nodes, nodes), np.bool_)
    stale[:, :] = True
    si = int(round((origin[0] - old_origin[0]) / spacing))
    sj = int(round((origin[1] - old_origin[1]) / spacing))
    nx, ny = clearance.shape
    for i in range(max(0, -si), min(nodes, nx - si)):
        for j in range(max(0, -sj), min(nodes, ny - sj)):
            new_clearance[i, j] = clearance[i + si, j + sj]
            new_source[i, j] = source[i + si, j + sj]
            new_free[i, j] = free[i + si, j + sj]
            stale[i, j] = False
    return new_clearance, new_source, new_free


@njit
def _see_free(free: np.ndarray, clearance: np.ndarray, source: np.ndarray, ends: np.ndarray, x: float, y: float,
              half_side: float, ox: float, oy: float, spacing: float) -> None:  # fmt: skip
    """Note where F says that the disc's centre is free; no longer where an observed boundary is now."""
    nx, ny = free.shape
    i0, i1, j0, j1 = window(x, y, x, y, half_side, ox, oy, spacing, nx, ny)
    for i in range(i0, i1):
        for j in range(j0, j1):
            if clearance[i, j] < 0.0 and source[i, j] == OBSERVED:
                free[i, j] = False
            elif not free[i, j]:
                free[i, j] = inside(ends, ox + i * spacing - x, oy + j * spacing - y)


@njit
def _update(pieces: np.ndarray, normals: np.ndarray, backed: np.ndarray, refuted: np.ndarray, seen: np.ndarray,
            doubted: np.ndarray, clearance: np.ndarray, source: np.ndarray, free: np.ndarray,
            old_origin: np.ndarray, origin: np.ndarray, keep_grid: bool, nodes: int, spacing: float,
            walls: np.ndarray, owner: np.ndarray, view: np.ndarray, sight: np.ndarray, half_side: float,
            ends: np.ndarray, position: np.ndarray, stamp: float, radius: float, depth: float, inset: float,
            margin: float, half: float, max_pieces: int) -> tuple[Any, ...]:  # fmt: skip
    ox, oy = origin[0], origin[1]
    rows = inferred_rows(depth, radius)
    deepest = rows[-1] if len(rows) > 0 else 0.0
    new, new_normals, inner = cut(walls, owner, sight[0], sight[1], half_side, spacing, inset)
    if len(rows) == 0:
        inner[:] = False
    before, most = len(pieces), len(pieces) + len(new)
    all_pieces, all_normals = np.empty((most, 4)), np.empty((most, 2))
    all_pieces[:before], all_normals[:before] = pieces, normals
    all_backed, all_refuted = np.zeros(most, np.bool_), np.zeros(most, np.bool_)
    all_backed[:before], all_refuted[:before] = backed, refuted
    all_seen, all_doubted = np.empty(most), np.zeros(most, np.int8)
    all_seen[:before], all_doubted[:before] = seen, doubted
    kept, fresh, raised = np.ones(most, np.bool_), np.zeros(most, np.bool_), np.zeros(most, np.bool_)
    judge(view, sight, half_side, margin, all_pieces[:before], all_normals[:before], all_backed, all_refuted,
          all_doubted, kept, rows)  # fmt: skip

    stale = np.zeros((nodes, nodes), np.bool_)
    if keep_grid:
        clearance, source, free = clearance.copy(), source.copy(), free.copy()
    else:
        clearance, source, free = _moved(clearance, source, free, old_origin, origin, nodes, spacing, stale)

    size = max(SMALLEST_BUCKET, 5.0 * spacing)
    n = int(math.ceil(2.0 * half / size)) + 1
    head, following = np.full(n * n, -1, np.int64), np.empty(most, np.int64)
    bx, by = position[0] - half, position[1] - half
    for k in range(before):
        mx, my = 0.5 * (all_pieces[k, 0] + all_pieces[k, 2]), 0.5 * (all_pieces[k, 1] + all_pieces[k, 3])
        if max(abs(mx - position[0]), abs(my - position[1])) > half:
            kept[k] = False
        if kept[k]:
            b = bucket_of(mx, my, bx, by, size, n)
            following[k], head[b] = head[b], k
    count = before
    for k in range(len(new)):
        refutable = inner[k] and (
            refutes(view, sight, half_side, new[k], new_normals[k], rows, margin)
            or _is_free(free, new[k], new_normals[k], rows, ox, oy, spacing)
        )
        count = take_up(new[k], new_normals[k], inner[k], refutable, stamp, count, all_pieces, all_normals,
                        all_backed, all_refuted, all_seen, all_doubted, kept, fresh, raised, head, following,
                        bx, by, size, n)  # fmt: skip
    excess = kept[:count].sum() - max_pieces
    if excess > 0:
        order = np.argsort(all_seen[:count], kind="mergesort")
        for k in order:
            if excess > 0 and kept[k]:
                kept[k] = False
                excess -= 1

    any_stale = not keep_grid
    for k in range(before):
        if not kept[k]:
            make_stale(stale, ox, oy, spacing, radius, all_pieces[k], all_normals[k], deepest if backed[k] else 0.0)
            any_stale = True
        elif backed[k] and not all_backed[k]:
            make_stale(stale, ox, oy, spacing, radius, all_pieces[k], all_normals[k], deepest)
            any_stale = True
    if any_stale:
        for i in range(nodes):
            for j in range(nodes):
                if stale[i, j]:
                    clearance[i, j], source[i, j] = FAR, 0
    for k in range(count):
        if not kept[k]:
            continue
        if k >= before or any_stale:
            lower_by_piece(clearance, source, stale, k >= before, ox, oy, spacing, radius, all_pieces[k])
        if all_backed[k] and (k >= before or any_stale or raised[k]):
            lower_behind_piece(clearance, source, stale, k >= before or raised[k], ox, oy, spacing, radius,
                               all_pieces[k], all_normals[k], rows)  # fmt: skip
    _see_free(free, clearance, source, ends, position[0], position[1], half_side, ox, oy, spacing)
    left = np.flatnonzero(kept[:count])
    return (all_pieces[left], all_normals[left], all_backed[left], all_refuted[left], all_seen[left],
            all_doubted[left], clearance, source, free)  # fmt: skip


@njit
def _is_free(free: np.ndarray, piece: np.ndarray, normal: np.ndarray, rows: np.ndarray, ox: float, oy: float,
             spacing: float) -> bool:  # fmt: skip
    """Whether the disc's centre was seen to be free where solid would be inferred behind a piece."""
    x, y = 0.5 * (piece[0] + piece[2]), 0.5 * (piece[1] + piece[3])
    for row in rows:
        i = int(math.floor((x - row * normal[0] - ox) / spacing + 0.5))
        j = int(math.floor((y - row * normal[1] - oy) / spacing + 0.5))
        if 0 <= i < free.shape[0] and 0 <= j < free.shape[1] and free[i, j]:
            return True
    return False
