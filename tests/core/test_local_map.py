"""The local map: of any scan, against the true configuration space, frontiers, predicted boundaries and sight."""

from itertools import product

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from collplan_core.local_map import build_local_map
from collplan_core.local_map.free_space import MAP_BORDER, UNSEEN_SURFACE
from collplan_core.local_map.frontiers import BORDER_RUN, SHADOW_EDGE
from collplan_core.local_map.sight import sight_angle
from collplan_core.parameters import LocalMapping
from collplan_core.scan import Scan
from scenes import (
    HALF_SIDE,
    RADIUS,
    ROBOT,
    TURN,
    at_rest,
    box,
    cluttered_worlds,
    free_polygon,
    map_of,
    map_of_ranges,
    obstacles,
    rotation,
    scan_of,
    star,
    true_reach,
    unit,
    world_of,
)


@st.composite
def any_scan(draw) -> Scan:
    n = draw(st.integers(30, 2000))
    span = draw(st.floats(0.2, TURN))
    increment = draw(st.sampled_from([-1.0, 1.0])) * span / draw(st.sampled_from([n, n - 1]))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    smooth = draw(st.floats(0.1, 2.0)) * (
        1.0 + draw(st.floats(0.0, 0.9)) * np.sin(np.arange(n) * draw(st.floats(0.0, 1.0)))
    )
    ranges = np.where(rng.random(n) < draw(st.floats(0.0, 1.0)), smooth, rng.uniform(0.0, 6.0, n))
    kinds = rng.random(n)
    shares = np.cumsum([draw(st.floats(0.0, 0.4)) for _ in range(3)])
    for share_low, share_high, value in zip([0.0, *shares[:2]], shares, [np.inf, -np.inf, np.nan], strict=True):
        ranges[(kinds >= share_low) & (kinds < share_high)] = value
    ranges[draw(st.integers(0, n - 1))] = draw(st.sampled_from([0.5, np.inf, -np.inf]))
    return Scan(0.0, draw(st.floats(-7.0, 7.0)), increment, 0.02, 5.0, ranges)


def border_reach(n: int, half_side: float) -> np.ndarray:
    angles = TURN * np.arange(n) / n
    return half_side / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))


def assert_sound(local_map, asked_position: np.ndarray) -> None:
    n = len(local_map.reach)
    offset = local_map.position - asked_position
    assert np.hypot(*offset) <= RADIUS * (1 + 1e-6)
    arrays = (local_map.reach, local_map.border_points, local_map.segments, local_map.predicted, local_map.normals)
    assert all(np.isfinite(a).all() for a in arrays)
    assert (local_map.reach >= 0.0).all()
    assert np.abs(local_map.border_points - asked_position).max() <= local_map.half_side + 1e-9
    if not offset.any():
        assert (local_map.reach <= border_reach(n, local_map.half_side) + 1e-9).all()
    # a star: every end lies in its own direction
    angles = TURN * np.arange(n) / n
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    np.testing.assert_allclose(local_map.border, local_map.reach[:, None] * directions, atol=1e-12)
    assert local_map.contains(local_map.position[None])[0]
    assert local_map.contains(local_map.position + 0.999 * local_map.border).all()
    beyond = local_map.position + local_map.border + 1e-3 * directions
    assert not local_map.contains(beyond).any()
    norms = np.hypot(*local_map.normals.T)
    assert np.allclose(norms[local_map.surface >= 0], 1.0)
    assert not norms[local_map.surface < 0].any()
    np.testing.assert_allclose(np.hypot(*local_map.predicted[:, 2:].T), 1.0, atol=1e-9)
    assert (np.hypot(*(local_map.segments[:, 2:] - local_map.segments[:, :2]).T) > 0.0).all()


@given(scan=any_scan(), yaw=st.floats(-10.0, 10.0), half_side=st.floats(0.2, 2.0))
def test_any_scan_gives_a_sound_map(scan, yaw, half_side):
    state = at_rest((3.0, -2.0), yaw)
    assert_sound(build_local_map(scan, state, ROBOT, LocalMapping(half_side=half_side)), state.position)


@given(world=cluttered_worlds(), n_beams=st.integers(30, 400))
def test_the_border_of_f_is_frontier_or_observed_and_nothing_is_both(world, n_beams):
    local_map = map_of(world, n_beams=n_beams)
    on_border = np.isclose(np.abs(local_map.border_points - local_map.position).max(axis=1), HALF_SIDE, atol=1e-9)
    assert on_border[local_map.surface == MAP_BORDER].all()
    runs = local_map.segments[local_map.frontier_kind == BORDER_RUN]
    assert np.isclose(np.abs(runs.reshape(-1, 2, 2)).max(axis=2), HALF_SIDE, atol=1e-9).all()
    steps = np.diff(local_map.frontier_number)
    assert ((steps == 0) | (steps == 1)).all()
    # wherever two neighbouring directions end on the map's border, the way between them is a border run
    pairs = np.flatnonzero((local_map.surface == MAP_BORDER) & (np.roll(local_map.surface, -1) == MAP_BORDER))
    middles = 0.5 * (local_map.border_points[pairs] + np.roll(local_map.border_points, -1, axis=0)[pairs])
    covered = shapely.multilinestrings(shapely.linestrings(runs.reshape(-1, 2, 2)))
    assert (shapely.distance(covered, shapely.points(middles)) < 0.02).all()


@given(world=cluttered_worlds(), yaw=st.floats(-7.0, 7.0), backwards=st.booleans())
def test_yaw_and_the_sense_of_turning_do_not_matter(world, yaw, backwards):
    straight = map_of(world)
    seen = scan_of(world, at_rest())
    scan = Scan(0.0, seen.angles[0] - yaw, TURN / 360, 0.02, 5.0, seen.ranges)
    if backwards:
        scan = Scan(0.0, seen.angles[-1] - yaw, -TURN / 360, 0.02, 5.0, seen.ranges[::-1])
    turned = build_local_map(scan, at_rest(yaw=yaw), ROBOT, LocalMapping())
    np.testing.assert_allclose(turned.reach, straight.reach, atol=1e-6)


def test_nan_is_unseen_and_blocks_and_minus_infinity_blocks_like_an_obstacle_at_the_least_range():
    ranges = np.full(360, np.inf)
    ranges[80:101] = np.nan
    local_map = map_of_ranges(ranges)
    assert (local_map.surface[80:101] == UNSEEN_SURFACE).all()
    assert not local_map.reach[80:101].any()
    assert (local_map.reach[[79, 101]] >= HALF_SIDE).all()
    assert not local_map.contains(np.array([[0.0, 0.05]]))[0]
    ranges[80:101] = -np.inf
    local_map = map_of_ranges(ranges)
    # too near means inside the grown obstacle: the robot is taken out of it, away from where nothing can be seen
    assert local_map.position[1] < -0.05
    assert not local_map.contains(np.array([[0.0, 0.03]]))[0]


def test_a_robot_inside_a_grown_obstacle_moves_to_the_nearest_point_of_its_border():
    for depth in (0.0, 1e-9, 0.001, 0.02, 0.06):
        local_map = map_of(world_of([box(RADIUS - depth, -3.0, 1.0, 3.0)]))
        np.testing.assert_allclose(local_map.position, [-depth, 0.0], atol=1e-5)
        assert local_map.reach[180] > 0.5
        assert local_map.reach[0] < 1e-3
        assert local_map.contains(np.array([[-0.3, 0.3], [0.05, 0.0]])).tolist() == [True, False]
    local_map = map_of(world_of([box(0.05, -3.0, 1.0, 3.0), box(-1.0, -3.0, -0.05, 3.0)]))
    assert np.hypot(*local_map.position) <= RADIUS + 1e-9  # stuck between two walls


@given(world=cluttered_worlds())
def test_a_dense_scan_gives_the_true_free_space(world):
    solid, origin = obstacles(world), np.zeros(2)
    assume(solid.is_empty or solid.distance(shapely.Point(origin)) > RADIUS + 1e-6)
    free = free_polygon(map_of(world, n_beams=2000, n_rays=1440))
    truth = shapely.make_valid(star(origin, true_reach(world, origin, 1440)))
    assert free.symmetric_difference(truth).area < 0.008
    if not solid.is_empty:
        rim = shapely.points(shapely.get_coordinates(free.segmentize(0.005)))
        assert RADIUS - shapely.distance(solid, rim).min() < 0.004


def test_a_wall_does_not_leak_however_few_the_beams():
    for n_beams, distance, degrees in product((30, 36, 60, 360), (0.12, 0.2, 0.4), (0.0, 5.0, 13.0, 40.0)):
        wall = box(-8.0, distance, 8.0, distance + 0.2) @ rotation(np.radians(degrees)).T
        local_map = map_of(world_of([wall]), n_beams=n_beams)
        depth = RADIUS - shapely.distance(shapely.Polygon(wall), shapely.points(local_map.border_points))
        # where the last beam to meet the wall ends, at the rim of what was seen, up to a chord's sagitta
        seen = np.hypot(*local_map.border.T) < 0.95 * HALF_SIDE
        assert depth[seen].max() < 1e-6, (n_beams, distance, degrees)


def edges(local_map) -> np.ndarray:
    return local_map.segments[local_map.frontier_kind == SHADOW_EDGE]


@given(n_beams=st.sampled_from([30, 60, 360, 1000]), distance=st.floats(0.1, 0.65), tilt=st.floats(-np.pi, np.pi))
def test_a_long_wall_is_one_surface_without_a_false_frontier(n_beams, distance, tilt):
    """However flat the beams graze it; at 30 beams from 0.2 m on: nearer, one wall in seventy has a false one."""
    assume(n_beams >= 60 or distance >= 0.2)
    wall = box(-8.0, distance, 8.0, distance + 0.2) @ rotation(tilt).T
    local_map = map_of(world_of([wall]), n_beams=n_beams)
    assert len(edges(local_map)) == 0
    assert set(local_map.surface) == {MAP_BORDER, 0}
    assert len(set(local_map.frontier_number)) == 1
    assert np.count_nonzero(local_map.surface != np.roll(local_map.surface, 1)) == 2


def test_a_gap_between_two_pillars_is_a_frontier_of_its_own_where_the_disc_fits():
    pillars = [box(0.3, 0.15, 0.4, 0.9), box(0.3, -0.9, 0.4, -0.15)]
    for n_beams in (60, 360, 1000):
        local_map = map_of(world_of(pillars), n_beams=n_beams)
        runs = local_map.segments[local_map.frontier_kind == BORDER_RUN]
        ahead = np.isclose(runs[:, [0, 2]], HALF_SIDE).all(axis=1) & (np.abs(runs[:, 1] + runs[:, 3]) < 0.05)
        assert ahead.sum() == 1
        # the disc's centre sees the border between the two grown corners
        beside = edges(local_map)
        assert len(beside[(beside[:, [0, 2]].min(axis=1) > 0.2) & (np.abs(beside[:, [1, 3]]).max(axis=1) < 0.2)]) == 2
    narrow = [box(0.3, RADIUS - 0.01, 0.4, 0.9), box(0.3, -0.9, 0.4, -RADIUS + 0.01)]
    border = map_of(world_of(narrow)).border_points
    assert (border[np.abs(border[:, 1]) < 0.5][:, 0] < 0.4).all()


def test_the_open_side_of_a_shadow_edge_is_the_farther_one():
    local_map = map_of(world_of([box(0.2, -0.05, 0.3, 0.05), box(0.5, -3.0, 0.6, 3.0)]))
    sides = local_map.open_side[local_map.frontier_kind == SHADOW_EDGE]
    for segment, (clockwise, counter_clockwise) in zip(edges(local_map), sides, strict=True):
        # clockwise lies the first end, counter-clockwise the second
        first, second = np.hypot(*segment[:2]), np.hypot(*segment[2:])
        assert clockwise == (first > second)
        assert counter_clockwise == (second > first)
    assert local_map.open_side[local_map.frontier_kind == BORDER_RUN].all()


PILLAR, WALL = box(0.2, -0.05, 0.3, 0.05), box(0.5, -3.0, 0.6, 3.0)
SIGHT_DISTANCE = 0.92 * HALF_SIDE


def test_by_hand_a_wall_behind_a_pillar_goes_on_behind_it_and_beyond_the_map():
    predicted = map_of(world_of([PILLAR, WALL])).predicted
    order = predicted[np.argsort(predicted[:, 1])]
    np.testing.assert_allclose(order[:, 0], 0.5 - RADIUS, atol=1e-9)
    np.testing.assert_allclose(order[:, 2:], [[0, -1], [0, 1], [0, -1], [0, 1]], atol=1e-9)
    bearing = np.arctan2(0.05, 0.2) + np.arcsin(RADIUS / np.hypot(0.2, 0.05))
    shadow = 0.41 * np.tan(bearing)
    np.testing.assert_allclose(order[:, 1], [-HALF_SIDE, -shadow, shadow, HALF_SIDE], atol=0.02)
    # the near end of a shadow edge is where a convex obstacle turns away
    assert len(map_of(world_of([PILLAR])).predicted) == 0


@given(world=cluttered_worlds())
def test_predicted_boundaries_begin_on_f_and_point_out_of_it(world):
    local_map = map_of(world)
    for x, y, ex, ey in local_map.predicted:
        origin, tangent = np.array([x, y]), np.array([ex, ey])
        assert np.hypot(ex, ey) == pytest.approx(1.0, abs=1e-9)
        assert np.min(np.hypot(*(local_map.border_points - origin).T)) < 1e-9
        # a step on, the obstacle's side of it lies beyond the map or in what is not known to be free; so far aside as a
        # rounded corner bends away from its tangent by 0.05^2 / (2 radius)
        aside = 0.02 * np.array([-ey, ex])
        assert not local_map.contains(origin + 0.05 * tangent + np.array([aside, -aside])).all()


@given(world=cluttered_worlds())
def test_as_printed_there_is_one_wherever_a_boundary_meets_a_frontier_and_those_that_go_on_are_among_them(world):
    read, printed = map_of(world), map_of(world, predicted="printed")
    observed, next_surface = printed.surface >= 0, np.roll(printed.surface, -1)
    at_border = ~printed.shadow & (
        (observed & (next_surface == MAP_BORDER)) | (np.roll(observed, -1) & (printed.surface == MAP_BORDER))
    )
    at_edges = printed.shadow * (observed.astype(int) + np.roll(observed, -1))
    assert len(printed.predicted) == at_edges.sum() + at_border.sum()
    assert set(map(tuple, read.predicted)) <= set(map(tuple, printed.predicted))


def test_by_hand_sight_is_counted_from_the_bearing_to_the_open_side_alone():
    reach = np.full(360, 0.2)
    reach[40:101] = HALF_SIDE
    x, y = 0.4 * unit(np.radians(60.25))
    assert sight_angle(reach, x, y, False, True, SIGHT_DISTANCE) == pytest.approx(np.radians(100 - 60.25))
    assert sight_angle(reach, x, y, True, False, SIGHT_DISTANCE) == pytest.approx(np.radians(60.25 - 40))
    assert sight_angle(reach, x, y, True, True, SIGHT_DISTANCE) == pytest.approx(np.radians(60))
    assert sight_angle(reach, x, y, False, False, SIGHT_DISTANCE) == 0.0
    # it is contiguous and needs the whole distance
    reach[80] = 0.99 * SIGHT_DISTANCE
    assert sight_angle(reach, x, y, False, True, SIGHT_DISTANCE) == pytest.approx(np.radians(79 - 60.25))
