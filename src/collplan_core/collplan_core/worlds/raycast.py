"""Exact ray casting: the scan that a LIDAR at a point would measure in a known world."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from collplan_core.jit import njit
from collplan_core.parameters import Lidar
from collplan_core.plane import rotate
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import World, world_segments

# a beam this close to a corner still meets both of its edges, so that none slips through between them
ANGLE_TOLERANCE = 1e-9
EDGE_TOLERANCE = 1e-12
NO_DISCS = np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class RayScene:
    """A world as the compiled loops take it."""

    segments: np.ndarray  # (s, 4) x0, y0, x1, y1 of the polygons' edges, polygon by polygon, then of the walls [m]
    polygon_starts: np.ndarray  # (p + 1,) where each polygon's segments start, and where the last one's end
    circles: np.ndarray  # (c, 3) x, y, radius [m]
    bounds: np.ndarray  # (4,) beyond these all is solid [m]; infinite when there are no walls


@lru_cache(maxsize=16)
def ray_scene(world: World) -> RayScene:
    """The world prepared for casting, once."""
    corners = [0, *(len(polygon) for polygon in world.polygons)]
    bounds = world.bounds if world.walled else (-np.inf, -np.inf, np.inf, np.inf)
    return RayScene(world_segments(world), np.cumsum(corners), np.array(world.circles), np.array(bounds))


def simulate_scan(world: World, state: State, lidar: Lidar, discs: np.ndarray = NO_DISCS) -> Scan:
    """Returns the scan of a world by a LIDAR mounted on the robot as in `lidar`; stamped as the state.

    `discs` (k, 3) x, y, radius [m] are movers, at their places then.

    A LIDAR on or inside an obstacle, or beyond the walls, is nearer than `range_min` in every direction.

    Raises:
        ValueError: the pose is not finite.
    """
    increment = beam_increment(lidar)
    ahead, left = rotate(lidar.offset_x, lidar.offset_y, state.yaw)
    x, y = float(state.position[0]) + ahead, float(state.position[1]) + left
    # the rays are cast counter-clockwise: of a LIDAR upside down the last beam is the first of them
    begins = -(lidar.angle_min + increment * (lidar.n_beams - 1)) if lidar.mirrored else lidar.angle_min
    first = state.yaw + begins + lidar.offset_yaw
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(first)):
        raise ValueError(f"pose: got position [{x}, {y}], first beam at {first} rad, expected finite numbers")
    scene = ray_scene(world)
    circles = np.vstack([scene.circles, discs]) if len(discs) else scene.circles
    if _blocked(x, y, scene.segments, scene.polygon_starts, circles, scene.bounds):
        ranges = np.full(lidar.n_beams, -np.inf)
    else:
        ranges = _nearest(x, y, scene.segments, circles, float(first), increment, lidar.n_beams)
        _apply_limits(ranges, lidar.range_min, lidar.range_max)
    ranges = ranges[::-1] if lidar.mirrored else ranges
    return Scan(state.stamp, lidar.angle_min, increment, lidar.range_min, lidar.range_max, ranges)


def cast_beams(world: World, origins: np.ndarray, angles: np.ndarray, discs: np.ndarray | None = None) -> np.ndarray:
    """Distance (n,) [m] to the nearest surface along beams that begin where each likes, world frame; +Inf without one.

    It is -Inf where a beam begins on or in an obstacle, or beyond the walls.

    Args:
        origins: (n, 2) where each beam begins [m].
        angles: (n,) its direction [rad].
        discs: (n, k, 3) x, y, radius [m] of the movers at the instant of each beam.
    """
    scene = ray_scene(world)
    points, directions = np.ascontiguousarray(origins, dtype=float), np.ascontiguousarray(angles, dtype=float)
    moved = np.zeros((len(angles), 0, 3)) if discs is None else np.ascontiguousarray(discs, dtype=float)
    return _along_each(points, directions, scene.segments, scene.polygon_starts, scene.circles, scene.bounds, moved)


def beam_increment(lidar: Lidar) -> float:
    """Step from beam to beam [rad]; over a full turn the last beam stops one step short of the first."""
    full_turn = lidar.angle_span > 2 * np.pi - 1e-6
    return lidar.angle_span / (lidar.n_beams if full_turn else lidar.n_beams - 1)


@njit
def _in_circle(x: float, y: float, circles: np.ndarray) -> bool:
    inside = False
    for c in range(len(circles)):
        inside = inside or math.hypot(circles[c, 0] - x, circles[c, 1] - y) <= circles[c, 2]
    return inside


@njit
def _blocked(
    x: float, y: float, segments: np.ndarray, polygon_starts: np.ndarray, circles: np.ndarray, bounds: np.ndarray
) -> bool:
    """Returns whether the point is on or in an obstacle, or on or beyond a wall."""
    if x <= bounds[0] or y <= bounds[1] or x >= bounds[2] or y >= bounds[3]:
        return True
    if _in_circle(x, y, circles):
        return True
    for p in range(len(polygon_starts) - 1):
        inside = True
        for s in range(polygon_starts[p], polygon_starts[p + 1]):
            edge_x, edge_y = segments[s, 2] - segments[s, 0], segments[s, 3] - segments[s, 1]
            # left of a counter-clockwise edge is the polygon's side
            if edge_x * (y - segments[s, 1]) - edge_y * (x - segments[s, 0]) < -EDGE_TOLERANCE:
                inside = False
                break
        if inside:
            return True
    return False


@njit
def _nearest(
    x: float, y: float, segments: np.ndarray, circles: np.ndarray, first: float, increment: float, n: int
) -> np.ndarray:
    """Distance to the nearest surface along each beam, +Inf where there is none."""
    ranges, beams = np.full(n, np.inf), np.empty((n, 2))
    for k in range(n):
        beams[k, 0], beams[k, 1] = math.cos(first + k * increment), math.sin(first + k * increment)
    for s in range(len(segments)):
        x0, y0, x1, y1 = segments[s, 0] - x, segments[s, 1] - y, segments[s, 2] - x, segments[s, 3] - y
        _cast_segment(x0, y0, x1, y1, first, increment, beams, ranges)
    for c in range(len(circles)):
        _cast_circle(circles[c, 0] - x, circles[c, 1] - y, circles[c, 2], first, increment, beams, ranges)
    return ranges


@njit
def _along_each(
    origins: np.ndarray,
    angles: np.ndarray,
    segments: np.ndarray,
    polygon_starts: np.ndarray,
    circles: np.ndarray,
    bounds: np.ndarray,
    discs: np.ndarray,
) -> np.ndarray:
    ranges = np.empty(len(angles))
    for k in range(len(angles)):
        x, y = origins[k, 0], origins[k, 1]
        if _blocked(x, y, segments, polygon_starts, circles, bounds) or _in_circle(x, y, discs[k]):
            ranges[k] = -np.inf
        else:
            beam_x, beam_y = math.cos(angles[k]), math.sin(angles[k])
            ranges[k] = _along(x, y, beam_x, beam_y, segments, circles)
            ranges[k] = min(ranges[k], _to_circle(x, y, beam_x, beam_y, discs[k]))
    return ranges


@njit
def _along(x: float, y: float, beam_x: float, beam_y: float, segments: np.ndarray, circles: np.ndarray) -> float:
    """Distance to the nearest surface along one beam (beam_x, beam_y), of length 1, +Inf where there is none."""
    nearest = np.inf
    for s in range(len(segments)):
        x0, y0 = segments[s, 0] - x, segments[s, 1] - y
        edge_x, edge_y = segments[s, 2] - segments[s, 0], segments[s, 3] - segments[s, 1]
        steepness = beam_x * edge_y - beam_y * edge_x
        if steepness == 0.0:
            continue  # seen edge-on: the edges beside it hold its ends
        share = (x0 * beam_y - y0 * beam_x) / steepness
        if -EDGE_TOLERANCE <= share <= 1.0 + EDGE_TOLERANCE:
            distance = (x0 + share * edge_x) * beam_x + (y0 + share * edge_y) * beam_y
            if distance >= 0.0:
                nearest = min(nearest, distance)
    return min(nearest, _to_circle(x, y, beam_x, beam_y, circles))


@njit
def _to_circle(x: float, y: float, beam_x: float, beam_y: float, circles: np.ndarray) -> float:
    nearest = np.inf
    for c in range(len(circles)):
        centre_x, centre_y, radius = circles[c, 0] - x, circles[c, 1] - y, circles[c, 2]
        miss, ahead = centre_x * beam_y - centre_y * beam_x, centre_x * beam_x + centre_y * beam_y
        if ahead > 0.0 and abs(miss) <= radius:
            nearest = min(nearest, max(0.0, ahead - math.sqrt((radius - miss) * (radius + miss))))
    return nearest


@njit
def _cast_segment(
    x0: float, y0: float, x1: float, y1: float, first: float, increment: float, beams: np.ndarray, ranges: np.ndarray
) -> None:
    """Shorten the beams that meet a segment, whose ends are given relative to the beams' origin."""
    edge_x, edge_y = x1 - x0, y1 - y0
    offset = x0 * edge_y - y0 * edge_x
    # a segment seen from its right side runs clockwise: begin at its other end
    bearing = math.atan2(y0, x0) if offset >= 0.0 else math.atan2(y1, x1)
    width = math.atan2(abs(offset), x0 * x1 + y0 * y1)
    for turn in range(-1, 2):
        start = (bearing - first) % (2 * math.pi) + turn * 2 * math.pi
        low, high = _beams_between(start - ANGLE_TOLERANCE, start + width + ANGLE_TOLERANCE, increment, len(beams))
        for k in range(low, high):
            steepness = beams[k, 0] * edge_y - beams[k, 1] * edge_x
            if steepness == 0.0:
                continue  # seen edge-on: the edges beside it hold its ends
            share = (x0 * beams[k, 1] - y0 * beams[k, 0]) / steepness
            if -EDGE_TOLERANCE <= share <= 1.0 + EDGE_TOLERANCE:
                # of the point on the segment, not offset / steepness: sound even where both are tiny
                distance = (x0 + share * edge_x) * beams[k, 0] + (y0 + share * edge_y) * beams[k, 1]
                ranges[k] = min(ranges[k], max(distance, 0.0))


@njit
def _cast_circle(
    x: float, y: float, radius: float, first: float, increment: float, beams: np.ndarray, ranges: np.ndarray
) -> None:
    """Shorten the beams that meet a circle, whose centre is given relative to the beams' origin outside it."""
    half = math.asin(min(1.0, radius / math.hypot(x, y)))
    for turn in range(-1, 2):
        start = (math.atan2(y, x) - half - first) % (2 * math.pi) + turn * 2 * math.pi
        low, high = _beams_between(start, start + 2 * half, increment, len(beams))
        for k in range(low, high):
            miss = x * beams[k, 1] - y * beams[k, 0]
            chord = math.sqrt(max(0.0, (radius - miss) * (radius + miss)))
            ranges[k] = min(ranges[k], max(0.0, x * beams[k, 0] + y * beams[k, 1] - chord))


@njit
def _beams_between(start: float, end: float, increment: float, n: int) -> tuple[int, int]:
    """First beam from `start` on and first beam past `end`, angles counted from the first beam."""
    return max(0, math.ceil(start / increment)), min(n, math.floor(end / increment) + 1)


@njit
def _apply_limits(ranges: np.ndarray, range_min: float, range_max: float) -> None:
    for k in range(len(ranges)):
        if ranges[k] < range_min:
            ranges[k] = -np.inf
        elif ranges[k] > range_max:
            ranges[k] = np.inf
