"""The free space F of the disc's centre as a star polygon: how far it can travel in each direction.

The obstacles are grown by the disc (configuration space), from the pieces of the scan alone. Points relative to the
centre of F.
"""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.seen import SeenSurfaces
from collplan_core.local_map.surfaces import HIT, OPEN, Sweep
from collplan_core.plane import nearest_on_segment
from collplan_core.sight_lines import place_towards

MAP_BORDER, UNSEEN_SURFACE = -1, -2
SIGHT_STEP = 0.02
"""Spacing of the places along a direction that are tested for being seen by a beam [m]."""


class FreeSpace(NamedTuple):
    """F in n directions around its centre; direction k is the bearing 2 pi k / n."""

    reach: np.ndarray  # (n,) free distance of the disc's centre [m]
    border: np.ndarray  # (n, 2) where F ends [m]
    surface: np.ndarray  # (n,) number of the observed surface that ends it, or MAP_BORDER or UNSEEN_SURFACE
    normals: np.ndarray  # (n, 2) unit normal out of the observed surface; zero elsewhere
    straight: np.ndarray  # (n,) whether it ends at a straight face


@njit
def nearest_free_offset(pieces: np.ndarray, radius: float) -> tuple[float, float]:
    """Offset that takes a robot inside a grown obstacle to the nearest point of its border; (0, 0) outside.

    Between two obstacles closer than the disc there is no such point: the last try is returned, never beyond radius.
    """
    x, y = 0.0, 0.0
    for _ in range(8):
        deepest, px, py = 0.0, 0.0, 0.0
        for k in range(len(pieces)):
            ax, ay, bx, by = pieces[k]
            cx, cy = nearest_on_segment(ax, ay, bx, by, x, y)
            d = math.hypot(x - cx, y - cy)
            if radius - d > deepest and d > 1e-9:
                deepest = radius - d
                px, py = (x - cx) / d * deepest, (y - cy) / d * deepest
        if deepest <= 1e-9:
            break
        x, y = x + px * (1.0 + 1e-6), y + py * (1.0 + 1e-6)
    length = math.hypot(x, y)
    return (x, y) if length <= radius else (x * radius / length, y * radius / length)


@njit
def map_border_distance(ux: float, uy: float, left: float, bottom: float, right: float, top: float) -> float:
    """Distance along the unit direction u from the origin to the border of the box around it."""
    tx = math.inf if ux == 0.0 else (right / ux if ux > 0.0 else left / ux)
    ty = math.inf if uy == 0.0 else (top / uy if uy > 0.0 else bottom / uy)
    return min(tx, ty)


@njit
def _enter_disc(ux: float, uy: float, cx: float, cy: float, radius: float) -> float:
    """Distance along u at which the centre comes within radius of c; 0 toward a c that is nearer, inf if never."""
    ahead = ux * cx + uy * cy
    if ahead <= 0.0:
        return math.inf
    rest = radius * radius - (ux * cy - uy * cx) ** 2
    if rest < 0.0:
        return math.inf
    return max(0.0, ahead - math.sqrt(rest))


@njit
def _enter_piece(
    ux: float, uy: float, ax: float, ay: float, bx: float, by: float, radius: float
) -> tuple[float, float, float, bool]:
    """Distance along u to the grown piece, the unit normal out of it there, and whether that is its straight face."""
    best, nx, ny = math.inf, 0.0, 0.0
    length = math.hypot(bx - ax, by - ay)
    if length > 1e-12:
        dx, dy = (bx - ax) / length, (by - ay) / length
        mx, my = -dy, dx
        height = -(ax * mx + ay * my)
        if height < 0.0:
            mx, my, height = -mx, -my, -height
        closing = -(ux * mx + uy * my)
        if closing > 0.0:
            t = max(0.0, (height - radius) / closing)  # 0 when touching, on whichever side rounding puts it
            along = (t * ux - ax) * dx + (t * uy - ay) * dy
            if 0.0 <= along <= length:
                return t, mx, my, True
    for cx, cy in ((ax, ay), (bx, by)):
        t = _enter_disc(ux, uy, cx, cy, radius)
        if t < best:
            px, py = t * ux - cx, t * uy - cy
            norm = max(math.hypot(px, py), 1e-12)
            best, nx, ny = t, px / norm, py / norm
    return best, nx, ny, False


@njit
def _seen_angle(cx: float, cy: float, radius: float) -> float:
    """Half the angle under which a disc is seen; a quarter turn from inside."""
    d = math.hypot(cx, cy)
    return math.pi / 2 if d <= radius else math.asin(radius / d)


@njit
def _block(piece: np.ndarray, owner: int, radius: float, directions: np.ndarray, free: FreeSpace) -> None:
    """Shorten the directions that meet the grown piece, visiting only those inside its angular interval."""
    reach, _, surface, normals, straight = free
    n = len(reach)
    step = 2.0 * math.pi / n
    ax, ay, bx, by = piece
    first = math.atan2(ay, ax)
    turn = math.atan2(ax * by - ay * bx, ax * bx + ay * by)
    alpha, beta = _seen_angle(ax, ay, radius), _seen_angle(bx, by, radius)
    low, high = first + min(-alpha, turn - beta), first + max(alpha, turn + beta)
    k_low, k_high = int(math.ceil(low / step - 1e-9)), int(math.floor(high / step + 1e-9))
    for j in range(k_low, min(k_high, k_low + n - 1) + 1):
        k = j % n
        t, nx, ny, face = _enter_piece(directions[k, 0], directions[k, 1], ax, ay, bx, by, radius)
        if t < reach[k]:
            reach[k], surface[k], straight[k] = t, owner, face
            normals[k, 0], normals[k, 1] = nx, ny


@njit
def _beams_at(place: float, m: int, sweep: Sweep) -> tuple[int, int]:
    """The one of m beams before a place among them and the one nearest to it; nearest -1 where the scan has none."""
    before = int(math.floor(place + 1e-9))
    nearest = int(math.floor(place + 0.5 + 1e-9))
    if sweep.closed:
        return before % m, nearest % m
    if nearest < m:
        return before, nearest
    just_below_first = place - 2.0 * math.pi / sweep.step >= -0.5 - 1e-9
    return (0, 0) if just_below_first else (before, -1)


@njit
def _limits_by_beams(found: SeenSurfaces, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns the limit of the nearest beam in each of n directions (n,) [m], and the surface it saw (n,)."""
    # Between two beams on one surface the pieces alone set the limit; elsewhere the nearest beam counts: else a sparse
    # scan leaks past the end of a surface. For beams that begin at the centre; `_end_where_unseen` for others.
    sweep, kind, distance, joined = found.sweep, found.kind, found.distance, found.joined
    m = len(kind)
    limit, seen = np.full(n, math.inf), np.full(n, MAP_BORDER)
    if len(found.origins) > 0:
        return limit, seen
    for k in range(n):
        place = ((2.0 * math.pi * k / n - sweep.first) % (2.0 * math.pi)) / sweep.step
        before, nearest = _beams_at(place, m, sweep)
        if nearest < 0:
            limit[k], seen[k] = 0.0, UNSEEN_SURFACE
        elif (before < m and joined[before]) or kind[nearest] == OPEN:
            continue
        elif kind[nearest] == HIT:
            limit[k], seen[k] = distance[nearest], found.surface_of[nearest]
        else:
            limit[k], seen[k] = 0.0, UNSEEN_SURFACE
    return limit, seen


@njit
def _what_hides(x: float, y: float, found: SeenSurfaces, guess: int) -> tuple[int, int]:
    """Returns the surface hiding a point from the beams beside it, MAP_BORDER where none does, and the nearest beam."""
    # Between two beams on one surface the farther of them counts, elsewhere the nearest beam.
    m = len(found.kind)
    place = place_towards(x, y, found.origins, found.sweep.first, found.sweep.step, guess)
    before, nearest = _beams_at(place, m, found.sweep)
    if nearest < 0:
        return UNSEEN_SURFACE, guess
    if found.kind[nearest] == OPEN:
        return MAP_BORDER, nearest
    if found.kind[nearest] != HIT:
        return UNSEEN_SURFACE, nearest
    far = found.distance[nearest]
    if before < m and found.joined[before]:
        far = max(found.distance[before], found.distance[(before + 1) % m])
    away = math.hypot(x - found.origins[nearest, 0], y - found.origins[nearest, 1])
    return (found.surface_of[nearest] if away > far else MAP_BORDER), nearest


@njit
def _end_where_unseen(found: SeenSurfaces, radius: float, directions: np.ndarray, free: FreeSpace) -> None:
    """Shortens the directions at the first place that no beam sees: beams that begin elsewhere see past other edges."""
    # The robot itself is where its disc is, which is therefore free.
    reach, _, surface, normals, straight = free
    guess = 0
    for k in range(len(reach)):
        ux, uy = directions[k]
        seen, t = 0.0, radius
        while t < reach[k]:
            by, guess = _what_hides(t * ux, t * uy, found, guess)
            if by == MAP_BORDER:
                seen, t = t, t + SIGHT_STEP
                continue
            hidden = t
            while seen > 0.0 and hidden - seen > 1e-3:
                middle = 0.5 * (seen + hidden)
                if _what_hides(middle * ux, middle * uy, found, guess)[0] == MAP_BORDER:
                    seen = middle
                else:
                    hidden = middle
            reach[k], surface[k], straight[k] = seen, by, False
            normals[k, 0], normals[k, 1] = (-ux, -uy) if by >= 0 else (0.0, 0.0)


@njit
def free_space(found: SeenSurfaces, radius: float, box: np.ndarray, n: int) -> FreeSpace:
    """F in n directions around the origin, from which the surfaces are seen. Paper: II-A.

    Args:
        radius: radius of the disc by which they are grown [m].
        box: (4,) the map's border x_min, y_min, x_max, y_max [m].
    """
    reach, border = np.empty(n), np.empty((n, 2))
    surface, normals, straight = np.empty(n, np.int64), np.zeros((n, 2)), np.zeros(n, np.bool_)
    free = FreeSpace(reach, border, surface, normals, straight)
    directions = np.empty((n, 2))
    limits, seen = _limits_by_beams(found, n)
    for k in range(n):
        ux, uy = math.cos(2.0 * math.pi * k / n), math.sin(2.0 * math.pi * k / n)
        directions[k, 0], directions[k, 1] = ux, uy
        map_border = map_border_distance(ux, uy, box[0], box[1], box[2], box[3])
        if limits[k] < map_border:
            reach[k], surface[k] = limits[k], seen[k]
            normals[k, 0], normals[k, 1] = -ux, -uy
        else:
            reach[k], surface[k] = map_border, MAP_BORDER
        if seen[k] == UNSEEN_SURFACE:
            normals[k, 0], normals[k, 1] = 0.0, 0.0
    beyond = math.hypot(max(-box[0], box[2]), max(-box[1], box[3])) + radius
    for j in range(len(found.pieces)):
        ax, ay, bx, by = found.pieces[j]
        cx, cy = nearest_on_segment(ax, ay, bx, by, 0.0, 0.0)
        if math.hypot(cx, cy) < beyond:
            _block(found.pieces[j], found.owner[j], radius, directions, free)
    if len(found.origins) > 0:
        _end_where_unseen(found, radius, directions, free)
    for k in range(n):
        border[k, 0], border[k, 1] = reach[k] * directions[k, 0], reach[k] * directions[k, 1]
    return free


@njit
def sector(x: float, y: float, n: int) -> int:
    """The direction k such that (x, y) lies between directions k and k + 1."""
    return int(math.floor((math.atan2(y, x) % (2.0 * math.pi)) * n / (2.0 * math.pi))) % n


@njit
def boundary_at(surface: np.ndarray, shadow: np.ndarray, k: int) -> int:
    """A direction of sector k whose observed boundary ends F there, -1 where F ends at a frontier or at the unseen."""
    j = (k + 1) % len(surface)
    if shadow[k] or (surface[k] < 0 and surface[j] < 0):
        return -1
    return k if surface[k] >= 0 else j


@njit
def inside(border: np.ndarray, x: float, y: float) -> bool:
    """Returns whether a point relative to the centre lies in F with border (n, 2): by sector and one cross product."""
    n = len(border)
    k = sector(x, y, n)
    ax, ay = border[k]
    bx, by = border[(k + 1) % n]
    # the edge alone is too short to judge by where the reach is next to nothing
    if x * x + y * y > max(ax * ax + ay * ay, bx * bx + by * by) + 1e-9:
        return False
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= -1e-9
