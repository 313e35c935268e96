"""Ray casting against shapely, under rotation and translation, and at its borders."""

import numpy as np
import pytest
import shapely
from hypothesis import example, given
from hypothesis import strategies as st

from collplan_core.parameters import Lidar
from collplan_core.scan import Scan
from collplan_core.state import State
from collplan_core.worlds import World, load_world
from collplan_core.worlds.raycast import beam_increment, simulate_scan
from scenes import TURN, cluttered_worlds

FAR = 100.0
BOUNDS = (0.0, 0.0, 4.0, 3.0)


def scan_at(world: World, position, n: int = 60, first: float = -np.pi, span: float = TURN, **limits: float) -> Scan:
    lidar = Lidar(
        n_beams=n, angle_min=float(first), angle_span=float(span), **{"range_min": 0.0, "range_max": FAR, **limits}
    )
    return simulate_scan(world, State(0.0, np.asarray(position, dtype=float), np.zeros(2), 0.0), lidar)


def world_of(polygons=(), circles=(), bounds=BOUNDS, walled=True) -> World:
    return World("w", tuple(np.array(p, dtype=float) for p in polygons), np.array(circles), bounds, walled)


positions = st.tuples(st.floats(-0.19, 0.19), st.floats(-0.19, 0.19)).map(np.array)


def shapely_blocked(world: World, position: np.ndarray) -> bool:
    point = shapely.Point(position)
    in_polygon = any(shapely.Polygon(corners).covers(point) for corners in world.polygons)
    return in_polygon or any(shapely.Point(x, y).distance(point) <= r for x, y, r in world.circles)


def shapely_range(world: World, position: np.ndarray, angle: float) -> float:
    direction = np.array([np.cos(angle), np.sin(angle)])
    origin, beam = shapely.Point(position), shapely.LineString([position, position + FAR * direction])
    rings = [shapely.LinearRing(corners) for corners in world.polygons]
    rings += [shapely.box(*world.bounds).exterior] if world.walled else []
    distances = [hit.distance(origin) for hit in (ring.intersection(beam) for ring in rings) if not hit.is_empty]
    for x, y, radius in world.circles:
        centre = shapely.Point(x, y)
        miss = beam.distance(centre)
        if miss <= radius and np.dot(direction, [x, y] - position) > 0.0:
            distances.append(beam.project(centre) - np.sqrt(radius**2 - miss**2))
    return min(distances, default=np.inf)


def graze_distance(world: World, position: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """(n,) How near each beam passes a corner or a circle's rim [m]: there a range leaps, and no two answers agree."""
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    corners = np.vstack([np.zeros((0, 2)), *world.polygons]) - position
    misses = np.abs(np.outer(direction[:, 0], corners[:, 1]) - np.outer(direction[:, 1], corners[:, 0]))
    centres = world.circles[:, :2] - position
    rims = np.abs(np.outer(direction[:, 0], centres[:, 1]) - np.outer(direction[:, 1], centres[:, 0]))
    return np.hstack([misses, np.abs(rims - world.circles[:, 2]), np.full((len(angles), 1), FAR)]).min(axis=1)


def assert_exact(world: World, scan: Scan, position: np.ndarray) -> None:
    if shapely_blocked(world, position):
        assert (scan.ranges == -np.inf).all()
        return
    sound = graze_distance(world, position, scan.angles) > 1e-5
    expected = np.array([shapely_range(world, position, a) for a in scan.angles])
    np.testing.assert_allclose(scan.ranges[sound], expected[sound], rtol=0.0, atol=1e-9)


SWEEPS = {"first": st.floats(-TURN, TURN), "span": st.floats(0.1, TURN)}


@given(world=cluttered_worlds(), position=positions, n=st.integers(30, 60), **SWEEPS)
def test_ranges_are_shapely_s(world, position, n, first, span):
    assert_exact(world, scan_at(world, position, n, first, span), position)


@given(world=cluttered_worlds(), position=positions, low=st.floats(0.01, 1.0), width=st.floats(0.1, 3.0))
def test_ranges_beyond_the_limits_are_infinite(world, position, low, width):
    ranges = scan_at(world, position, 90).ranges
    limited = scan_at(world, position, 90, range_min=low, range_max=low + width).ranges
    expected = np.where(ranges < low, -np.inf, np.where(ranges > low + width, np.inf, ranges))
    np.testing.assert_array_equal(limited, expected)


SQUARE = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]
CIRCLE = [3.0, 1.0, 0.5]


def test_inside_an_obstacle_or_beyond_the_walls_all_is_too_near():
    for position in [(1.5, 1.5), (1.0, 1.5), (3.2, 1.1), (3.5, 1.0), (0.0, 1.5), (4.0, 3.0), (-0.1, 1.5)]:
        world = world_of([SQUARE], [CIRCLE])
        assert (scan_at(world, position).ranges == -np.inf).all(), position
    # of an open arena the obstacles are seen from outside
    world = world_of([SQUARE], walled=False)
    ranges = scan_at(world, (-1.0, 1.5), 30, 0.0).ranges
    np.testing.assert_allclose(ranges[[0, 15]], [2.0, np.inf])


@example(distance=0.5, side=0.0, n=360)
@example(distance=1.0, side=1.0, n=32)
@given(distance=st.floats(0.01, 1.0), side=st.floats(0.0, 1.0), n=st.integers(30, 720))
def test_no_beam_slips_through_a_corner_between_two_edges(distance, side, n):
    bounds = (-distance, -distance, 1.0 + side, 2.0)
    world = world_of(bounds=bounds)
    for x, y in ((bounds[0], bounds[1]), (bounds[2], bounds[1]), (bounds[0], bounds[3])):
        ranges = scan_at(world, (0.0, 0.0), n, np.arctan2(y, x)).ranges
        assert np.isfinite(ranges).all()
        assert ranges[0] == pytest.approx(np.hypot(x, y), abs=1e-9)


def test_a_pose_that_is_not_finite_is_refused():
    for x, yaw in [(np.nan, 0.0), (np.inf, 0.0), (1.0, np.nan)]:
        with pytest.raises(ValueError, match="pose: got"):
            simulate_scan(world_of(), State(0.0, np.array([x, 1.0]), np.zeros(2), yaw), Lidar())


def test_beams_cover_their_span_and_a_full_turn_repeats_none():
    for n_beams in [30, 360, 2000]:
        for span in [0.5, np.pi, TURN]:
            lidar = Lidar(n_beams=n_beams, angle_min=-1.0, angle_span=span)
            scan = simulate_scan(load_world("corridor"), State(0.0, np.array([1.12, 0.23]), np.zeros(2), 0.3), lidar)
            last = -1.0 + span - (beam_increment(lidar) if span == TURN else 0.0)
            assert scan.angles[[0, -1]] == pytest.approx([-1.0, last]), span
            assert len(scan.ranges) == n_beams, span
