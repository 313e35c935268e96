"""The set E of predicted boundaries, and theta_sight, on scenes whose answer is known."""

import numpy as np
import pytest
from hypothesis import given, settings

from collplan_core.local_map.free_space import MAP_BORDER
from collplan_core.local_map.sight import sight_angle
from scenes import HALF_SIDE, RADIUS, box, cluttered_worlds, map_of, unit, world_of

PILLAR, WALL = box(0.2, -0.05, 0.3, 0.05), box(0.5, -3.0, 0.6, 3.0)
SIGHT_DISTANCE = 0.92 * HALF_SIDE


def test_by_hand_a_wall_behind_a_pillar_goes_on_behind_it_and_beyond_the_map():
    """The wall at x = 0.5 is seen above and below the pillar: it goes on into the shadow and out of the map."""
    predicted = map_of(world_of([PILLAR, WALL])).predicted
    order = predicted[np.argsort(predicted[:, 1])]
    np.testing.assert_allclose(order[:, 0], 0.5 - RADIUS, atol=1e-9)
    np.testing.assert_allclose(order[:, 2:], [[0, -1], [0, 1], [0, -1], [0, 1]], atol=1e-9)
    bearing = np.arctan2(0.05, 0.2) + np.arcsin(RADIUS / np.hypot(0.2, 0.05))
    shadow = 0.41 * np.tan(bearing)
    np.testing.assert_allclose(order[:, 1], [-HALF_SIDE, -shadow, shadow, HALF_SIDE], atol=0.02)


def test_by_hand_a_pillar_alone_predicts_nothing():
    """The near end of a shadow edge is where a convex obstacle turns away."""
    assert len(map_of(world_of([PILLAR])).predicted) == 0


@settings(derandomize=True, deadline=None, max_examples=40, print_blob=True)
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


@settings(derandomize=True, deadline=None, max_examples=40, print_blob=True)
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
    ends = printed.segments.reshape(-1, 2)
    for line in printed.predicted:
        assert np.hypot(*line[2:]) == pytest.approx(1.0, abs=1e-9)
        assert np.min(np.hypot(*(printed.border_points - line[:2]).T)) < 1e-9
        if not (read.predicted == line).all(axis=1).any():
            assert np.min(np.hypot(*(ends - line[:2]).T)) < 1e-9


def test_by_hand_sight_is_counted_from_the_bearing_to_the_open_side_alone():
    """Open from 40 to 100 degrees, seen from a candidate at 60.25 degrees."""
    reach = np.full(360, 0.2)
    reach[40:101] = HALF_SIDE
    x, y = 0.4 * unit(np.radians(60.25))
    assert sight_angle(reach, x, y, False, True, SIGHT_DISTANCE) == pytest.approx(np.radians(100 - 60.25))
    assert sight_angle(reach, x, y, True, False, SIGHT_DISTANCE) == pytest.approx(np.radians(60.25 - 40))
    assert sight_angle(reach, x, y, True, True, SIGHT_DISTANCE) == pytest.approx(np.radians(60))
    assert sight_angle(reach, x, y, False, False, SIGHT_DISTANCE) == 0.0


def test_by_hand_sight_is_contiguous_and_needs_the_whole_distance():
    reach = np.full(360, 0.2)
    reach[40:101] = HALF_SIDE
    reach[80] = 0.99 * SIGHT_DISTANCE
    x, y = 0.4 * unit(np.radians(60.0))
    assert sight_angle(reach, x, y, False, True, SIGHT_DISTANCE) == pytest.approx(np.radians(79 - 60))
