"""The local map of any scan at all, and of the special places a robot gets into."""

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.local_map import build_local_map
from collplan_core.local_map.free_space import MAP_BORDER, UNSEEN_SURFACE
from collplan_core.local_map.frontiers import BORDER_RUN
from collplan_core.parameters import LocalMapping
from collplan_core.scan import Scan, ScanError
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
    scan_of,
    world_of,
)

QUICK = settings(derandomize=True, deadline=None, max_examples=60, print_blob=True)
LONG = settings(derandomize=True, deadline=None, max_examples=3000, print_blob=True)


@st.composite
def any_scan(draw) -> Scan:
    """Any count, angle range, direction of turn and mix of finite, infinite and invalid ranges."""
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


@QUICK
@given(scan=any_scan(), yaw=st.floats(-10.0, 10.0), half_side=st.floats(0.2, 2.0))
def test_any_scan_gives_a_sound_map(scan, yaw, half_side):
    state = at_rest((3.0, -2.0), yaw)
    assert_sound(build_local_map(scan, state, ROBOT, LocalMapping(half_side=half_side)), state.position)


@pytest.mark.soak
@pytest.mark.timeout(900)
@LONG
@given(scan=any_scan(), yaw=st.floats(-10.0, 10.0), half_side=st.floats(0.2, 2.0))
def test_any_scan_gives_a_sound_map_in_many_more_cases(scan, yaw, half_side):
    state = at_rest((3.0, -2.0), yaw)
    assert_sound(build_local_map(scan, state, ROBOT, LocalMapping(half_side=half_side)), state.position)


@QUICK
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


@QUICK
@given(world=cluttered_worlds(), yaw=st.floats(-7.0, 7.0), backwards=st.booleans())
def test_yaw_and_the_sense_of_turning_do_not_matter(world, yaw, backwards):
    """The same beams in the world, given from another heading and in the other order, give the same map."""
    straight = map_of(world)
    seen = scan_of(world, at_rest())
    scan = Scan(0.0, seen.angles[0] - yaw, TURN / 360, 0.02, 5.0, seen.ranges)
    if backwards:
        scan = Scan(0.0, seen.angles[-1] - yaw, -TURN / 360, 0.02, 5.0, seen.ranges[::-1])
    turned = build_local_map(scan, at_rest(yaw=yaw), ROBOT, LocalMapping())
    np.testing.assert_allclose(turned.reach, straight.reach, atol=1e-6)


def test_a_scan_of_nan_alone_is_an_error():
    with pytest.raises(ScanError, match="all 360 are NaN"):
        map_of_ranges(np.full(360, np.nan))


def test_everything_open_is_one_frontier_around_the_whole_map():
    local_map = map_of_ranges(np.full(360, np.inf))
    np.testing.assert_allclose(local_map.reach, border_reach(360, HALF_SIDE), atol=1e-12)
    assert (local_map.surface == MAP_BORDER).all()
    assert set(local_map.frontier_kind) == {BORDER_RUN}
    assert set(local_map.frontier_number) == {0}
    lengths = np.hypot(*(local_map.segments[:, 2:] - local_map.segments[:, :2]).T)
    assert lengths.sum() == pytest.approx(8 * HALF_SIDE)
    assert len(local_map.predicted) == 0
    assert local_map.observed_boundaries() == []


def test_a_closed_small_room_has_no_frontier_and_one_boundary():
    local_map = map_of(world_of(bounds=(-0.4, -0.3, 0.4, 0.3), walled=True))
    assert len(local_map.segments) == 0
    assert len(local_map.predicted) == 0
    (boundary,) = local_map.observed_boundaries()
    room = shapely.box(-0.4 + RADIUS, -0.3 + RADIUS, 0.4 - RADIUS, 0.3 - RADIUS)
    assert free_polygon(local_map).symmetric_difference(room).area < 1e-3
    assert len(boundary) == 361


def test_nan_is_unseen_and_blocks():
    ranges = np.full(360, np.inf)
    ranges[80:101] = np.nan
    local_map = map_of_ranges(ranges)
    assert (local_map.surface[80:101] == UNSEEN_SURFACE).all()
    assert not local_map.reach[80:101].any()
    assert (local_map.reach[[79, 101]] >= HALF_SIDE).all()
    assert not local_map.contains(np.array([[0.0, 0.05]]))[0]


def test_minus_infinity_blocks_like_an_obstacle_at_the_least_range():
    ranges = np.full(360, np.inf)
    ranges[80:101] = -np.inf
    local_map = map_of_ranges(ranges)
    # too near means inside the grown obstacle: the robot is taken out of it, away from where nothing can be seen
    assert local_map.position[1] < -0.05
    assert not local_map.contains(np.array([[0.0, 0.03]]))[0]


def test_angles_not_scanned_are_unseen():
    local_map = map_of_ranges(np.full(91, np.inf), angle_min=-np.pi / 4, increment=np.pi / 180)
    seen = local_map.surface == MAP_BORDER
    assert seen[:46].all()
    assert seen[-45:].all()
    assert not seen[47:-46].any()
    assert not local_map.contains(np.array([[-0.1, 0.0]]))[0]


@pytest.mark.parametrize("depth", [1e-9, 0.001, 0.02, 0.06])
def test_a_robot_inside_a_grown_obstacle_moves_to_the_nearest_point_of_its_border(depth):
    local_map = map_of(world_of([box(RADIUS - depth, -3.0, 1.0, 3.0)]))
    np.testing.assert_allclose(local_map.position, [-depth, 0.0], atol=1e-5)
    assert local_map.reach[180] > 0.5
    assert local_map.reach[0] < 1e-3
    assert local_map.contains(np.array([[-0.3, 0.3]]))[0]
    assert not local_map.contains(np.array([[0.05, 0.0]]))[0]


def test_touching_a_wall_leaves_the_half_plane_before_it():
    local_map = map_of(world_of([box(RADIUS, -3.0, 1.0, 3.0)]))
    half = shapely.box(-HALF_SIDE, -HALF_SIDE, 0.0, HALF_SIDE)
    assert free_polygon(local_map).symmetric_difference(half).area < 0.01


def test_stuck_between_two_walls_the_robot_stays_within_a_radius():
    local_map = map_of(world_of([box(0.05, -3.0, 1.0, 3.0), box(-1.0, -3.0, -0.05, 3.0)]))
    assert np.hypot(*local_map.position) <= RADIUS + 1e-9
    assert np.isfinite(local_map.border_points).all()


def test_clearance_grows_obstacles_further():
    world = world_of([box(0.4, -3.0, 1.0, 3.0)])
    assert map_of(world).reach[0] == pytest.approx(0.4 - RADIUS)
    assert map_of(world, clearance=0.05).reach[0] == pytest.approx(0.4 - RADIUS - 0.05)


@QUICK
@given(world=cluttered_worlds(), x=st.floats(-0.7, 0.7), y=st.floats(-0.7, 0.7))
def test_membership_is_that_of_the_polygon(world, x, y):
    local_map = map_of(world)
    polygon, point = free_polygon(local_map), shapely.Point(x, y)
    if polygon.exterior.distance(point) > 1e-6:
        assert local_map.contains(np.array([[x, y]]))[0] == polygon.contains(point)
