"""F from a scan against the true configuration space, which shapely grows from the world itself."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings

from collplan_core.worlds import load_world
from scenes import (
    HALF_SIDE,
    RADIUS,
    box,
    cluttered_worlds,
    free_polygon,
    map_of,
    map_of_ranges,
    obstacles,
    rotation,
    star,
    true_reach,
    world_of,
)

ORIGIN = np.zeros(2)
DENSE = {"n_beams": 2000, "n_rays": 1440}


def robot_is_free(world) -> bool:
    solid = obstacles(world)
    return solid.is_empty or solid.distance(shapely.Point(ORIGIN)) > RADIUS + 1e-6


def assert_true(world, position=ORIGIN) -> None:
    solid = obstacles(world)
    local_map = map_of(world, position, **DENSE)
    free = free_polygon(local_map)
    truth = shapely.make_valid(star(position, true_reach(world, position, 1440)))
    assert free.symmetric_difference(truth).area < 0.008
    if not solid.is_empty:
        rim = shapely.points(shapely.get_coordinates(free.segmentize(0.005)))
        assert RADIUS - shapely.distance(solid, rim).min() < 0.004


@settings(derandomize=True, deadline=None, max_examples=40, print_blob=True)
@given(world=cluttered_worlds())
def test_a_dense_scan_gives_the_true_free_space(world):
    assume(robot_is_free(world))
    assert_true(world)


@pytest.mark.soak
@pytest.mark.timeout(900)
@settings(derandomize=True, deadline=None, max_examples=600, print_blob=True)
@given(world=cluttered_worlds())
def test_a_dense_scan_gives_the_true_free_space_in_many_more_worlds(world):
    assume(robot_is_free(world))
    assert_true(world)


@pytest.mark.parametrize("name", ["corridor", "l_corridor", "slalom", "random:3"])
def test_a_dense_scan_gives_the_true_free_space_in_the_arenas(name):
    world = load_world(name)
    assert_true(world, world.start)


@settings(derandomize=True, deadline=None, max_examples=40, print_blob=True)
@given(world=cluttered_worlds())
def test_directions_away_from_tangents_have_their_true_reach(world):
    """At 360 beams, where the true reach is smooth over some degrees it is met to a few millimetres."""
    assume(robot_is_free(world))
    truth = true_reach(world, ORIGIN, 360)
    turned = np.stack([np.roll(truth, s) for s in range(-3, 4)])
    smooth = np.ptp(turned, axis=0) < 0.05
    assert np.abs(map_of(world).reach - truth)[smooth].max(initial=0.0) < 0.015


@pytest.mark.parametrize("n_beams", [30, 36, 60, 360])
@pytest.mark.parametrize("distance", [0.12, 0.2, 0.4])
@pytest.mark.parametrize("tilt", np.radians([0.0, 5.0, 13.0, 40.0]))
def test_a_wall_does_not_leak_however_few_the_beams(n_beams, distance, tilt):
    wall = box(-8.0, distance, 8.0, distance + 0.2) @ rotation(tilt).T
    local_map = map_of(world_of([wall]), n_beams=n_beams)
    depth = RADIUS - shapely.distance(shapely.Polygon(wall), shapely.points(local_map.border_points))
    # where the last beam to meet the wall ends, at the rim of what was seen, up to a chord's sagitta
    seen = np.hypot(*local_map.border.T) < 0.95 * HALF_SIDE
    assert depth[seen].max() < 1e-6


@pytest.mark.parametrize("n_beams", [30, 60])
def test_a_small_room_does_not_leak_at_few_beams(n_beams):
    local_map = map_of(world_of(bounds=(-0.4, -0.45, 0.5, 0.35), walled=True), n_beams=n_beams)
    room = shapely.box(-0.4 + RADIUS, -0.45 + RADIUS, 0.5 - RADIUS, 0.35 - RADIUS)
    assert free_polygon(local_map).difference(room).area < 1e-6


def test_by_hand_a_wall_ahead():
    """Wall at x = 0.4: reach (0.4 - R) / cos, and the border of the map elsewhere."""
    local_map = map_of(world_of([box(0.4, -3.0, 0.6, 3.0)]))
    for degrees, expected in [
        (0, 0.31),
        (30, 0.31 / np.cos(np.pi / 6)),
        (45, 0.31 * np.sqrt(2)),
        (90, 0.6),
        (180, 0.6),
    ]:
        assert local_map.reach[degrees] == pytest.approx(expected, abs=1e-9)


def test_by_hand_a_post_ahead():
    """A thin post at x = 0.4: d cos - sqrt(R^2 - d^2 sin^2) within asin(R / d), free beyond."""
    local_map = map_of(world_of(circles=[(0.4, 0.0, 0.001)]), n_beams=2000)
    for degrees in (0, 5, 10):
        delta = np.radians(degrees)
        expected = 0.4 * np.cos(delta) - np.sqrt(0.091**2 - (0.4 * np.sin(delta)) ** 2)
        assert local_map.reach[degrees] == pytest.approx(expected, abs=2e-3)
    beyond = int(np.ceil(np.degrees(np.arcsin(0.091 / 0.4)))) + 1
    assert local_map.reach[beyond] >= HALF_SIDE


def test_by_hand_one_hit_is_a_disc():
    ranges = np.full(360, np.inf)
    ranges[90] = 0.3
    local_map = map_of_ranges(ranges)
    assert local_map.reach[90] == pytest.approx(0.3 - RADIUS)
    delta = np.radians(10.0)
    assert local_map.reach[100] == pytest.approx(0.3 * np.cos(delta) - np.sqrt(RADIUS**2 - (0.3 * np.sin(delta)) ** 2))
    assert local_map.reach[90 + 18] >= HALF_SIDE
