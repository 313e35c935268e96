"""The surfaces that one scan shows, found once for the local map and for the plausibility of scans."""

import math
from typing import NamedTuple

import numpy as np

from collplan_core.jit import njit
from collplan_core.local_map.surfaces import HIT, OPEN, Sweep, beam_kinds, find_surfaces, fit_pieces
from collplan_core.plane import rotate_rows
from collplan_core.scan import Scan
from collplan_core.sight_lines import repeats_first
from collplan_core.state import State

GRAZING_ANGLE = math.radians(10.0)
"""Smallest angle between beam and surface that still joins two hits: Borges and Aldon 2004 [rad]."""
SURFACE_TOLERANCE = 0.001
"""Largest distance of a hit from the straight piece fitted to its surface [m]."""
FLAT, FADES = math.sin(math.radians(15.0)), 4.0
"""Sine between beam and wall below which a LIDAR may get nothing back, though it is no farther than this [m]."""
BEHIND = 3
"""Number of hits before the end of a surface that its direction is taken from."""


class SeenSurfaces(NamedTuple):
    """Surfaces that the n beams of a scan met, counter-clockwise, along the world's axes from the robot's centre."""

    stamp: float  # stamp of the scan [s]
    sweep: Sweep  # geometry of the beams
    kind: np.ndarray  # (n,) HIT, OPEN or UNSEEN
    distance: np.ndarray  # (n,) range of a hit, inf where open, 0 where unseen [m]
    hits: np.ndarray  # (n, 2) points met [m]; zero without a hit
    joined: np.ndarray  # (n,) whether beam i and the next one see one surface
    pieces: np.ndarray  # (m, 4) straight pieces x0, y0, x1, y1 along the surfaces [m]
    owner: np.ndarray  # (m,) number of the surface a piece is of
    surface_of: np.ndarray  # (n,) number of the surface a beam met, -1 without a hit
    piece_of: np.ndarray  # (n,) number of the piece between whose ends a beam met it, -1 at its ends and without a hit
    fades: np.ndarray
    """(n,) whether a beam that measured nothing may have met the straight on of a wall beside it, too flatly."""
    origins: np.ndarray
    """(n, 3) where each begins x, y [m], and how much farther than `sweep` says it is turned [rad]; (0, 3) where all
    begin at the robot's centre."""


def seen_surfaces(scan: Scan, state: State) -> SeenSurfaces:
    """The surfaces in a scan from the pose at its stamp. Each beam begins where the sensor was at its instant."""
    ranges, first, step = scan.ranges, scan.angle_min + state.yaw, scan.angle_increment
    beams = _around_robot(scan, state)
    if step < 0.0:
        ranges, first, step, beams = ranges[::-1], first + step * (len(ranges) - 1), -step, beams[::-1]
    if repeats_first(len(ranges), step):
        ranges, beams = ranges[:-1], beams[: len(ranges) - 1]
    closed = abs(step * len(ranges) - 2 * math.pi) < 0.5 * step
    sweep = Sweep(first, step, closed, scan.range_min, GRAZING_ANGLE, SURFACE_TOLERANCE)
    return _see(scan.stamp, np.ascontiguousarray(ranges), sweep, np.ascontiguousarray(beams))


def _around_robot(scan: Scan, state: State) -> np.ndarray:
    """(n, 3) sensor at each beam: x, y from the robot's centre along the world's axes [m], yaw in the robot [rad]."""
    # (0, 3) where it is at the robot's centre all the time.
    if scan.sensor_poses is None:
        return np.zeros((0, 3))
    return np.column_stack([rotate_rows(scan.sensor_poses[:, :2], state.yaw), scan.sensor_poses[:, 2]])


@njit
def _see(stamp: float, ranges: np.ndarray, sweep: Sweep, origins: np.ndarray) -> SeenSurfaces:
    kind, distance = beam_kinds(ranges, sweep.range_min)
    hits = np.zeros((len(ranges), 2))
    for i in range(len(ranges)):
        if kind[i] == HIT:
            bearing = sweep.first + i * sweep.step
            if len(origins) > 0:
                bearing += origins[i, 2]
            hits[i, 0] = distance[i] * math.cos(bearing)
            hits[i, 1] = distance[i] * math.sin(bearing)
            if len(origins) > 0:
                hits[i, 0] += origins[i, 0]
                hits[i, 1] += origins[i, 1]
    joined = find_surfaces(kind, distance, hits, sweep)
    pieces, owner, surface_of, piece_of = fit_pieces(kind, hits, joined, sweep.tolerance)
    fades = _fading(kind, hits, surface_of, sweep)
    return SeenSurfaces(stamp, sweep, kind, distance, hits, joined, pieces, owner, surface_of, piece_of, fades, origins)


@njit
def _fading(kind: np.ndarray, hits: np.ndarray, surface_of: np.ndarray, sweep: Sweep) -> np.ndarray:
    """(n,) `fades` of the surfaces."""
    n, found = len(kind), np.zeros(len(kind), dtype=np.bool_)
    for end in range(n):
        for onward in (-1, 1):
            i, back, surface = end + onward, end - BEHIND * onward, surface_of[end]
            if not sweep.closed and not (0 <= i < n and 0 <= back < n):
                continue
            if kind[i % n] != OPEN or surface < 0 or surface != surface_of[back % n]:
                continue
            x, y = hits[end]
            dx, dy = x - hits[back % n, 0], y - hits[back % n, 1]
            beside, bearing, away = x * dy - y * dx, math.atan2(y, x), 0.0
            if abs(beside) > FLAT * math.hypot(x, y) * math.hypot(dx, dy):
                continue
            while kind[i % n] == OPEN and 0.0 <= away <= FADES:
                bearing += onward * sweep.step
                across = math.cos(bearing) * dy - math.sin(bearing) * dx
                away = beside / across if across != 0.0 else math.inf
                found[i % n] |= 0.0 < away <= FADES
                i += onward
    return found


def of_each_beam(found: np.ndarray, scan: Scan, missing: float) -> np.ndarray:
    """(b, ...) values of a scan's own beams from those (n, ...) of its surfaces, which are in counter-clockwise order.

    `missing` is that of a last beam which repeats the first.
    """
    fill = np.full((len(scan.ranges) - len(found), *found.shape[1:]), missing, found.dtype)
    found = np.concatenate([found, fill]) if len(fill) else found
    return found[::-1] if scan.angle_increment < 0.0 else found


@njit
def seen_from(seen: SeenSurfaces, x: float, y: float) -> SeenSurfaces:
    """The surfaces from a point x, y [m] in place of the robot's centre."""
    if x == 0.0 and y == 0.0:
        return seen
    stamp, sweep, kind, distance, hits, joined, pieces, owner, surface_of, piece_of, fades, origins = seen
    hits, pieces = hits - np.array([x, y]), pieces - np.array([x, y, x, y])
    origins = origins - np.array([x, y, 0.0])
    return SeenSurfaces(stamp, sweep, kind, distance, hits, joined, pieces, owner, surface_of, piece_of, fades, origins)
