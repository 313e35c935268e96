"""Views: the free space and the surfaces that a scan saw, with which the returns of later scans are compared."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.seen import SeenSurfaces
from collplan_core.local_map.surfaces import HIT, OPEN
from collplan_core.plane import nearest_on_segment
from collplan_core.scan import Scan
from collplan_core.sight_lines import directions_of, last_before, place_towards

OPEN_RUN = 10
"""Number of neighbouring beams without a hit from which on they count as free: a few may be lost ones."""
FARTHEST_FREE = 4.0
"""They vouch for so much at most [m]."""
SIGMAS = 3.0
"""Deviations of the ranges' noise by which a return must lie within free space."""
SURE = 1e-9
"""Distances that only leave out edges too far away are wider by this than rounding can make them [m]."""


class View(NamedTuple):
    """One scan as the polygon of its hits, in the order of its n beams, world frame.

    A beam that measured nothing vouches for nothing: the polygon then runs through the sensor. One among many that met
    nothing within range ends there.
    """

    stamp: float  # stamp of the scan [s]
    hits: np.ndarray  # (n, 2) ends of the beams [m], the sensor's place where one vouches for nothing
    vouches: np.ndarray  # (n,) whether a beam was free up to its end
    is_hit: np.ndarray  # (n,) whether it met something there
    stands: np.ndarray  # (n,) whether the edge from hit i to the next one lies on a surface that is no mover's
    beams: np.ndarray  # (n, 3) x, y [m] and turn beyond `first` [rad] of the sensor at each beam
    first: float  # bearing of the first beam [rad]
    step: float  # angle from beam to beam [rad]
    closed: bool  # whether the first beam follows the last one; not of a sweep, as the sensor has moved on
    noise: float  # standard deviation of a range [m]
    directions: np.ndarray  # (n, 2) of the beams, or (0, 2), of `directions_of`
    edges: np.ndarray
    """(n, 9) of the edge from hit i to the next one, the sensor's place after the last where it does not close: x, y of
    both ends, x, y of the sensor at beam i, distance of the farther end from there, and at least and at most its
    distance from the sensor at the first beam [m]."""


def view_of(scan: Scan, noise: float, seen: SeenSurfaces, position: np.ndarray) -> View:
    """The view of a scan, from it and its noise [m], its surfaces, and the robot's position (2,) at its stamp [m]."""
    n, swept = len(seen.kind), len(seen.origins) > 0 and bool(np.ptp(seen.origins[:, :2], axis=0).any())
    beams, hits, is_hit = _placed(seen.kind, seen.hits, seen.origins, *position.tolist())
    vouches, closed, (first, step) = is_hit, seen.sweep.closed and not swept, seen.sweep[:2]
    is_open = seen.kind == OPEN
    if is_open.any():
        is_open = _of_a_run(is_open & ~seen.fades, OPEN_RUN) & np.isfinite(scan.range_max)
        bearings = first + step * np.arange(n) + beams[:, 2]
        far = np.where(is_open, min(scan.range_max, FARTHEST_FREE), 0.0)[:, None]
        ends = beams[:, :2] + far * np.column_stack([np.cos(bearings), np.sin(bearings)])
        hits, vouches = np.where(is_hit[:, None], hits, ends), is_hit | is_open
    directions, edges = directions_of(beams, first, step), _edges_of(hits, beams, closed)
    return View(seen.stamp, hits, vouches, is_hit, seen.joined, beams, first, step, closed, noise, directions, edges)


@njit
def _placed(
    kind: np.ndarray, hits: np.ndarray, origins: np.ndarray, x: float, y: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Beams (n, 3), their hits (n, 2), or else where they begin, both in the world, and which of them have a hit."""
    beams, ends, is_hit = np.zeros((len(kind), 3)), np.empty((len(kind), 2)), kind == HIT
    beams[: len(origins)] = origins
    for k in range(len(kind)):
        beams[k, 0] += x
        beams[k, 1] += y
        ends[k, 0] = hits[k, 0] + x if is_hit[k] else beams[k, 0]
        ends[k, 1] = hits[k, 1] + y if is_hit[k] else beams[k, 1]
    return beams, ends, is_hit


def _of_a_run(which: np.ndarray, shortest: int) -> np.ndarray:
    """(n,) those of the flags (n,) that stand in a row with others, at least so many."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], which, [False]])))
    found = np.zeros(len(which), bool)
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        found[begin:end] = end - begin >= shortest
    return found


@njit
def _edges_of(hits: np.ndarray, beams: np.ndarray, closed: bool) -> np.ndarray:
    """(n, 9) `edges` of a view."""
    n, x, y = len(hits), beams[0, 0], beams[0, 1]
    edges = np.empty((n, 9))
    for i in range(n):
        ax, ay, bx, by = hits[i, 0], hits[i, 1], beams[i, 0], beams[i, 1]
        edges[i, 0], edges[i, 1], edges[i, 4], edges[i, 5] = ax, ay, bx, by
        if closed or i + 1 < n:
            bx, by = hits[(i + 1) % n, 0], hits[(i + 1) % n, 1]
        edges[i, 2], edges[i, 3] = bx, by
        edges[i, 6] = max(
            math.hypot(ax - beams[i, 0], ay - beams[i, 1]), math.hypot(bx - beams[i, 0], by - beams[i, 1])
        )
        nx, ny = nearest_on_segment(ax, ay, bx, by, x, y)
        edges[i, 7] = math.sqrt((nx - x) ** 2 + (ny - y) ** 2) - SURE
        edges[i, 8] = math.sqrt(max((ax - x) ** 2 + (ay - y) ** 2, (bx - x) ** 2 + (by - y) ** 2)) + SURE
    return edges


@njit
def _is_near(edges: np.ndarray, i: int, x: float, y: float, distance: float) -> bool:
    """Returns whether a point is nearer than a distance [m] to edge i."""
    nx, ny = nearest_on_segment(edges[i, 0], edges[i, 1], edges[i, 2], edges[i, 3], x, y)
    return (x - nx) * (x - nx) + (y - ny) * (y - ny) < distance * distance


@njit
def _beams_around(n: int, step: float, away: float, distance: float) -> int:
    """Number of beams of n to each side within a distance of a point, which is so far `away` [m]."""
    return n // 2 if distance >= away else min(n // 2, int(math.asin(distance / away) / step) + 2)


@njit
def _beam_before(beams: np.ndarray, first: float, step: float, closed: bool, x: float, y: float) -> int:
    """The last beam before a point, or -1 where none and its successor enclose it, as at the seam of a sweep."""
    n = len(beams)
    place = int(place_towards(x, y, beams, first, step, n // 2))
    if place >= n or (place == n - 1 and not closed):
        return -1
    bearing = math.atan2(y - beams[place, 1], x - beams[place, 0]) - beams[place, 2]
    off = bearing - first - place * step
    off -= 2.0 * math.pi * round(off / (2.0 * math.pi))
    # of a sweep the two beams have places of their own
    return place if -step < off < 2.0 * step else -1


@njit
def _is_inside(edges: np.ndarray, step: float, closed: bool, place: int, x: float, y: float, margin: float) -> bool:
    """Whether a point between a beam and the next lies in the polygon, farther than a margin from its edges."""
    # The depth counts from every edge: what comes into view behind a tip lies outside of the polygon, and what is near
    # the edge of its shadow is within the margin.
    n, away = len(edges), math.hypot(x - edges[place, 4], y - edges[place, 5])
    ax, ay, bx, by = edges[place, 0], edges[place, 1], edges[place, 2], edges[place, 3]
    if edges[place, 6] - away < margin or (bx - ax) * (y - ay) - (by - ay) * (x - ax) <= 0.0:
        return False
    width = _beams_around(n, step, away, margin)
    if not closed and not width <= place < n - width:
        return False
    for k in range(2 * width + 1):
        i = place + _from_the_middle(k)
        if _is_near(edges, i if i < n else i - n, x, y, margin):
            return False
    return True


@njit
def _from_the_middle(k: int) -> int:
    """The k-th of 0, 1, -1, 2, -2, ...: a return is nearly always near the edge of its own beam."""
    return (k + 1) // 2 if k % 2 else -(k // 2)


@njit
def _is_on_surface(
    edges: np.ndarray, stands: np.ndarray, step: float, closed: bool, place: int, x: float, y: float, in_place: float
) -> bool:
    """Returns whether a point between a beam and the next lies on a surface that stands."""
    if stands[place] and _is_near(edges, place, x, y, in_place):
        return True
    n, away = len(edges), math.hypot(x - edges[place, 4], y - edges[place, 5])
    from_first = math.sqrt((x - edges[0, 4]) ** 2 + (y - edges[0, 5]) ** 2)
    for k in range(1, 2 * _beams_around(n, step, away, in_place) + 1):
        i = place + _from_the_middle(k)
        if not closed and not 0 <= i < n:
            continue
        # below 0 counts from the end by itself
        i = i if i < n else i - n
        may_be = stands[i] and edges[i, 7] < from_first + in_place and from_first - in_place < edges[i, 8]
        if may_be and _is_near(edges, i, x, y, in_place):
            return True
    return False


@njit
def look_at_each(
    fields: tuple,
    hits: np.ndarray,
    looked: np.ndarray,
    moved: np.ndarray,
    stands: np.ndarray,
    reach: tuple[float, float],
) -> None:
    """Looks at the returns of a later scan, and notes in `moved` and `stands` what is found.

    One that stands by one view is not asked about again, whatever others show: views that tell what stands come first.
    The margin grows by the noise of ranges, and by the spacing of this view's beams at the point: a tip that stands
    hides between two of them.

    Args:
        fields: fields of a View after its stamp: a plain tuple costs a fifth of a named one to hand over.
        hits: (n, 2) points met [m]; `looked` (n,) which of them are looked at.
        moved, stands: (n,) those seen free there, and those where a surface that stands was.
        reach: depth in the polygon from which on a return was seen free, and largest distance from a surface that is
            the same place [m]; with 0 none is looked for.
    """
    _, vouches, _, surfaces, beams, first, step, closed, noise, directions, edges = fields
    n, place, blur, (margin, in_place) = len(edges), 0, SIGMAS * noise, reach
    for i in range(len(hits)):
        if not looked[i] or stands[i] or (moved[i] and in_place == 0.0):
            continue
        x, y = hits[i, 0], hits[i, 1]
        place = last_before(directions, place, x - beams[0, 0], y - beams[0, 1])
        if place < 0:
            place = _beam_before(beams, first, step, closed, x, y)
        if place < 0:
            continue
        stands[i] = in_place > 0.0 and _is_on_surface(edges, surfaces, step, closed, place, x, y, in_place)
        if stands[i] or moved[i]:
            continue
        dx, dy = x - beams[place, 0], y - beams[place, 1]
        # nearly all are on the polygon, which a root tells in less time than `_is_inside`
        if edges[place, 6] - math.sqrt(dx * dx + dy * dy) > margin - SURE:
            moved[i] = (
                vouches[place]
                and vouches[place + 1 if place + 1 < n else 0]
                and _is_inside(edges, step, closed, place, x, y, margin + (blur + step * math.hypot(dx, dy)))
            )


def saw_free(view: View, x: float, y: float, margin: float) -> bool:
    """Returns whether a view saw a point as free, deeper than a margin [m], which grows as in `look_at_each`."""
    is_free = np.zeros(1, bool)
    look_at_each(view[1:], np.array([[x, y]]), np.ones(1, bool), is_free, np.zeros(1, bool), (margin, 0.0))
    return bool(is_free[0])


def without_surfaces(view: View, discs: np.ndarray) -> View:
    """A view whose surfaces within discs (m, 3) x, y, radius [m] vouch for nothing that stands."""
    return view._replace(stands=view.stands & ~_are_within(view.hits, discs))


@njit
def _are_within(points: np.ndarray, discs: np.ndarray) -> np.ndarray:
    """(n,) whether each of the points (n, 2) is in one of the discs (m, 3)."""
    found = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        for k in range(len(discs)):
            dx, dy = points[i, 0] - discs[k, 0], points[i, 1] - discs[k, 1]
            if dx * dx + dy * dy < discs[k, 2] * discs[k, 2]:
                found[i] = True
    return found
