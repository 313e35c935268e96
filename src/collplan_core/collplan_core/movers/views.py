"""Views: the free space and the surfaces that a scan saw, with which the returns of later scans are compared."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.seen import SeenSurfaces
from collplan_core.local_map.surfaces import HIT, OPEN
from collplan_core.plane import nearest_on_segment
from collplan_core.scan import Scan
from collplan_core.sight_lines import place_towards

OPEN_RUN = 10
"""Number of neighbouring beams without a hit from which on they count as free: a few may be lost ones."""
FARTHEST_FREE = 4.0
"""They vouch for so much at most [m]."""
SIGMAS = 3.0
"""Deviations of the ranges' noise by which a return must lie within free space."""


class View(NamedTuple):
    """One scan as the polygon of its hits, in the order of its n beams, world frame.

    A beam that measured nothing vouches for nothing: the polygon then runs through the sensor. One among many that met
    nothing within range ends there.

    Attributes:
        stamp: stamp of the scan [s].
        hits: (n, 2) ends of the beams [m], the sensor's place where one vouches for nothing.
        vouches: (n,) whether a beam was free up to its end; is_hit: (n,) whether it met something there.
        stands: (n,) whether the edge from hit i to the next one lies on a surface that is no mover's.
        beams: (n, 3) x, y [m] and turn beyond `first` [rad] of the sensor at each beam.
        first: bearing of the first beam; step: angle from beam to beam [rad].
        closed: whether the first beam follows the last one; not of a sweep, as the sensor has moved on.
        noise: standard deviation of a range [m].
    """

    stamp: float
    hits: np.ndarray
    vouches: np.ndarray
    is_hit: np.ndarray
    stands: np.ndarray
    beams: np.ndarray
    first: float
    step: float
    closed: bool
    noise: float


def view_of(scan: Scan, noise: float, seen: SeenSurfaces, position: np.ndarray) -> View:
    """The view of a scan, from it and its noise [m], its surfaces, and the robot's position (2,) at its stamp [m]."""
    n, swept = len(seen.kind), len(seen.origins) > 0 and bool(np.ptp(seen.origins[:, :2], axis=0).any())
    beams = (seen.origins if len(seen.origins) else np.zeros((n, 3))) + np.array([*position, 0.0])
    is_hit, is_open = seen.kind == HIT, _of_a_run(seen.kind == OPEN, OPEN_RUN) & np.isfinite(scan.range_max)
    bearings = seen.sweep.first + seen.sweep.step * np.arange(n) + beams[:, 2]
    far = np.where(is_open, min(scan.range_max, FARTHEST_FREE), 0.0)[:, None]
    ends = beams[:, :2] + far * np.column_stack([np.cos(bearings), np.sin(bearings)])
    hits = np.where(is_hit[:, None], seen.hits + position, ends)
    closed, (first, step) = seen.sweep.closed and not swept, seen.sweep[:2]
    return View(seen.stamp, hits, is_hit | is_open, is_hit, seen.joined, beams, first, step, closed, noise)


def _of_a_run(which: np.ndarray, shortest: int) -> np.ndarray:
    """(n,) those of the flags (n,) that stand in a row with others, at least so many."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], which, [False]])))
    found = np.zeros(len(which), bool)
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        found[begin:end] = end - begin >= shortest
    return found


@njit
def _corner(view: View, i: int) -> tuple[float, float]:
    """Corner i of the polygon; the sensor's place beyond the ends of one that does not close."""
    n = len(view.hits)
    if view.closed:
        i = i + n if i < 0 else (i - n if i >= n else i)
    elif i < 0 or i >= n:
        k = 0 if i < 0 else n - 1
        return view.beams[k, 0], view.beams[k, 1]
    return view.hits[i, 0], view.hits[i, 1]


@njit
def _is_near_edge(view: View, i: int, x: float, y: float, distance: float) -> bool:
    """Returns whether a point is nearer than a distance [m] to the edge from corner i to the next one."""
    (ax, ay), (bx, by) = _corner(view, i), _corner(view, i + 1)
    nx, ny = nearest_on_segment(ax, ay, bx, by, x, y)
    return (x - nx) * (x - nx) + (y - ny) * (y - ny) < distance * distance


@njit
def _beams_around(view: View, away: float, distance: float) -> int:
    """Number of beams to each side within a distance of a point, which is so far `away` [m]."""
    n = len(view.hits)
    return n // 2 if distance >= away else min(n // 2, int(math.asin(distance / away) / view.step) + 2)


@njit
def _beam_before(view: View, x: float, y: float) -> int:
    """The last beam before a point, or -1 where none and its successor enclose it, as at the seam of a sweep."""
    n = len(view.hits)
    place = int(place_towards(x, y, view.beams, view.first, view.step, n // 2))
    if place >= n or (place == n - 1 and not view.closed):
        return -1
    bearing = math.atan2(y - view.beams[place, 1], x - view.beams[place, 0]) - view.beams[place, 2]
    off = bearing - view.first - place * view.step
    off -= 2.0 * math.pi * round(off / (2.0 * math.pi))
    # of a sweep the two beams have places of their own
    return place if -view.step < off < 2.0 * view.step else -1


@njit
def _is_free(view: View, place: int, x: float, y: float, margin: float) -> bool:
    """Returns whether a point between a beam and the next lies in the polygon, farther than a margin from its edges.

    The margin grows by the noise of ranges, and by the spacing of this view's beams at the point: a tip that stands
    hides between two of them. The depth counts from every edge: what comes into view behind a tip lies outside of the
    polygon, and what is near the edge of its shadow is within the margin.
    """
    n = len(view.hits)
    if not (view.vouches[place] and view.vouches[(place + 1) % n]):
        return False
    away = math.hypot(x - view.beams[place, 0], y - view.beams[place, 1])
    margin += SIGMAS * view.noise + view.step * away
    (ax, ay), (bx, by) = _corner(view, place), _corner(view, place + 1)
    farther = max(
        math.hypot(ax - view.beams[place, 0], ay - view.beams[place, 1]),
        math.hypot(bx - view.beams[place, 0], by - view.beams[place, 1]),
    )
    if farther - away < margin or (bx - ax) * (y - ay) - (by - ay) * (x - ax) <= 0.0:
        return False
    width = _beams_around(view, away, margin)
    if not view.closed and not width <= place < n - width:
        return False
    for k in range(2 * width + 1):  # noqa: SIM110 (numba has no generators)
        if _is_near_edge(view, place + _from_the_middle(k), x, y, margin):
            return False
    return True


@njit
def _from_the_middle(k: int) -> int:
    """The k-th of 0, 1, -1, 2, -2, ...: a return is nearly always near the edge of its own beam."""
    return (k + 1) // 2 if k % 2 else -(k // 2)


@njit
def _is_on_surface(view: View, place: int, x: float, y: float, in_place: float) -> bool:
    """Returns whether a point between a beam and the next lies on a surface that stands."""
    n = len(view.hits)
    away = math.hypot(x - view.beams[place, 0], y - view.beams[place, 1])
    width = _beams_around(view, away, in_place)
    for k in range(2 * width + 1):
        i = place + _from_the_middle(k)
        if (view.closed or 0 <= i < n) and view.stands[i % n] and _is_near_edge(view, i, x, y, in_place):
            return True
    return False


@njit
def saw_free(view: View, x: float, y: float, margin: float) -> bool:
    """Returns whether a view saw a point as free, deeper than a margin [m], which grows as in `_is_free`."""
    place = _beam_before(view, x, y)
    return place >= 0 and _is_free(view, place, x, y, margin)


@njit
def look_at_each(
    view: View, hits: np.ndarray, looked: np.ndarray, unsure: np.ndarray, margin: float, in_place: float
) -> tuple[np.ndarray, np.ndarray]:
    """Looks at the returns of a later scan.

    Args:
        hits: (n, 2) points met [m]; `looked` (n,) which of them are looked at.
        unsure: (n,) for which of them a surface in the same place is looked for.
        margin: of `saw_free` [m]; `in_place`: largest distance from a surface that is the same place [m].

    Returns:
        (n,) whether it was seen free there, and (n,) whether a surface that stands was.
    """
    free, surface = np.zeros(len(hits), np.bool_), np.zeros(len(hits), np.bool_)
    for i in range(len(hits)):
        place = _beam_before(view, hits[i, 0], hits[i, 1]) if looked[i] else -1
        if place < 0:
            continue
        x, y = hits[i, 0], hits[i, 1]
        free[i] = _is_free(view, place, x, y, margin)
        surface[i] = unsure[i] and _is_on_surface(view, place, x, y, in_place)
    return free, surface


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
