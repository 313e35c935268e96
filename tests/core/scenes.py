"""Hand-made and drawn worlds with the local maps that scans of them give, and the true configuration space."""

from dataclasses import replace

import numpy as np
import shapely
from hypothesis import strategies as st

from collplan_core.control.motion_monitor import MotionRecord, add_command, add_pose
from collplan_core.local_map import LocalMap, build_local_map
from collplan_core.local_map.free_space import MAP_BORDER
from collplan_core.movers.record import Movers
from collplan_core.parameters import Lidar, Settings
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import World
from collplan_core.worlds.raycast import simulate_scan

SETTINGS = Settings()
ROBOT, RADIUS = SETTINGS.robot, SETTINGS.robot.radius
HALF_SIDE = SETTINGS.local_map.half_side
TURN = 2 * np.pi
WIDE = (-5.0, -5.0, 5.0, 5.0)


def unit(angle: float) -> np.ndarray:
    return np.array([np.cos(angle), np.sin(angle)])


def rotation(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def mover_at(x: float, y: float = 0.0, velocity=(0.0, 0.0), stamp: float = 0.0, radius=0.12, growth=0.0) -> Movers:
    one = np.ones(1)
    return Movers(
        stamp, np.ones(1, int), np.array([(x, y)]), np.array([velocity]), radius * one, growth * one, stamp * one
    )


def posed(record: MotionRecord, state: State, now: float, touching: bool) -> MotionRecord:
    """The record with one more pose, in that of the drive too."""
    return add_pose(record, record.drive.with_pose(state, now), touching)


def commanded(record: MotionRecord, velocity: np.ndarray, now: float) -> MotionRecord:
    """The record with one more command, in that of the drive too."""
    return add_command(record, record.drive.with_command(velocity, now))


def box(x0: float, y0: float, x1: float, y1: float) -> np.ndarray:
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def world_of(polygons=(), circles=(), bounds=WIDE, walled=False) -> World:
    return World("scene", tuple(np.array(p, dtype=float) for p in polygons), np.array(circles), bounds, walled)


def at_rest(position=(0.0, 0.0), yaw: float = 0.0, velocity=(0.0, 0.0)) -> State:
    return State(0.0, np.array(position, dtype=float), np.array(velocity, dtype=float), yaw)


def scan_of(world: World, state: State, n_beams: int = 360, **lidar) -> Scan:
    return simulate_scan(world, state, Lidar(n_beams=n_beams, **lidar))


def map_of(world: World, position=(0.0, 0.0), n_beams: int = 360, **mapping) -> LocalMap:
    state = at_rest(position)
    return build_local_map(scan_of(world, state, n_beams), state, ROBOT, replace(SETTINGS.local_map, **mapping))


def map_of_ranges(ranges: np.ndarray) -> LocalMap:
    """The map of a robot at the origin from ranges [m] over a full turn."""
    scan = Scan(0.0, 0.0, TURN / len(ranges), 0.02, 5.0, ranges)
    return build_local_map(scan, at_rest(), ROBOT, SETTINGS.local_map)


def star_map(reach, surface=None) -> LocalMap:
    """A map without frontiers written by hand, from its reach in evenly spaced directions."""
    reach = np.asarray(reach, dtype=float)
    n, angles = len(reach), TURN * np.arange(len(reach)) / len(reach)
    return LocalMap(
        stamp=0.0,
        position=np.zeros(2),
        radius=RADIUS,
        half_side=HALF_SIDE,
        reach=reach,
        border_points=reach[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1),
        surface=np.full(n, MAP_BORDER) if surface is None else np.asarray(surface),
        normals=np.zeros((n, 2)),
        shadow=np.zeros(n, bool),
        segments=np.zeros((0, 4)),
        frontier_kind=np.zeros(0, int),
        frontier_number=np.zeros(0, int),
        open_side=np.ones((0, 2), bool),
        predicted=np.zeros((0, 4)),
    )


def free_polygon(local_map: LocalMap) -> shapely.Polygon:
    return shapely.make_valid(shapely.Polygon(local_map.border_points))


def _solids(world: World) -> list[shapely.Geometry]:
    shapes = [shapely.Polygon(p) for p in world.polygons]
    shapes += [shapely.Point(x, y).buffer(r, quad_segs=128) for x, y, r in world.circles]
    if world.walled:
        arena = shapely.box(*world.bounds)
        shapes.append(arena.buffer(1.0, join_style="mitre").difference(arena))
    return shapes


def obstacles(world: World) -> shapely.Geometry:
    return shapely.union_all(_solids(world))


def grown(world: World, radius: float = RADIUS) -> shapely.Geometry:
    # one by one: GEOS has been seen to buffer a union of walls and circles by too much
    return shapely.union_all([solid.buffer(radius, quad_segs=64) for solid in _solids(world)])


def true_reach(world: World, position: np.ndarray, n: int) -> np.ndarray:
    """(n,) distance to the nearest grown obstacle or the map's border in direction 2 pi k / n, by shapely."""
    square = shapely.box(*(position - HALF_SIDE), *(position + HALF_SIDE))
    blocked = shapely.union(grown(world), square.buffer(3.0, join_style="mitre").difference(square))
    angles = TURN * np.arange(n) / n
    far = position + 4.0 * HALF_SIDE * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    beams = shapely.linestrings(np.stack([np.broadcast_to(position, far.shape), far], axis=1))
    return shapely.distance(shapely.Point(position), shapely.intersection(beams, blocked))


def star(position: np.ndarray, reach: np.ndarray) -> shapely.Polygon:
    angles = TURN * np.arange(len(reach)) / len(reach)
    return shapely.Polygon(position + reach[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))


def uneven_world(rng: np.random.Generator) -> World:
    """Polygons around the origin, without the symmetries that shrinking looks for: there rounding decides ties."""
    polygons = []
    for _ in range(rng.integers(0, 6)):
        size = rng.uniform(0.05, 0.3)
        center = (RADIUS + 0.02 + size + rng.uniform(0.0, 0.6)) * unit(rng.uniform(0.0, TURN))
        angles = rng.uniform(0.0, TURN) + TURN * np.arange(n := rng.integers(3, 7)) / n
        polygons.append(center + size * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    walled = bool(rng.integers(2))
    bounds = (*rng.uniform(-1.5, -0.2, 2), *rng.uniform(0.2, 1.5, 2))
    return world_of(polygons, (), bounds if walled else WIDE, walled)


@st.composite
def cluttered_worlds(draw, most: int = 5) -> World:
    """Polygons and circles around a robot at the origin that touches none of them."""
    polygons, circles = [], []
    for _ in range(draw(st.integers(0, most))):
        bearing, size = draw(st.floats(0.0, 6.28)), draw(st.floats(0.05, 0.3))
        center = (RADIUS + 0.02 + size + draw(st.floats(0.0, 0.6))) * unit(bearing)
        if draw(st.booleans()):
            circles.append((*center, size))
        else:
            angles = draw(st.floats(0.0, 6.28)) + TURN * np.arange(n := draw(st.integers(3, 6))) / n
            polygons.append(center + size * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    walled = draw(st.booleans())
    # no two corners of the room equally far away: which comes first would be the beams' affair
    spans = ((-1.5, -0.2), (-1.5, -0.21), (0.2, 1.5), (0.2, 1.5))
    odd = (-0.0117, -0.0271, 0.0393, 0.0531)
    bounds = tuple(draw(st.floats(*span)) + extra for span, extra in zip(spans, odd, strict=True))
    return world_of(polygons, circles, bounds if walled else WIDE, walled)
