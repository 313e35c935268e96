"""S x Theta x V on hand-made frontiers. Paper: II-A."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.paper_planner.candidates import SPEED_COUNTS, long_enough, product, sample_positions

V_MAX = 1.2

corners = st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)), min_size=2, max_size=5)


def chain(points, number: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """One frontier of straight pieces through the points."""
    points = np.array(points, dtype=float)
    return np.hstack([points[:-1], points[1:]]), np.full(len(points) - 1, number)


def test_by_hand_short_frontiers_are_passed_over_where_a_longer_one_is_seen():
    """A notch of 3 cm, and a frontier of two pieces of 4 cm."""
    chains = chain([(0.0, 0.0), (0.03, 0.0)], 0), chain([(0.0, 1.0), (0.04, 1.0), (0.08, 1.0)], 1)
    segments, number = (np.concatenate(part) for part in zip(*chains, strict=True))
    assert long_enough(segments, number, 0.05).tolist() == [False, True, True]
    assert long_enough(segments, number, 0.1).all(), "no longer one is seen"
    assert long_enough(segments, number, 0.0).all(), "as printed"


def test_by_hand_positions_are_the_centres_of_equal_cells():
    """Four cells; one of a short frontier; 0.3 m + 0.1 m round a corner at 0.2 m: centres at 0.1 m and 0.3 m."""
    table = [
        ([(0.0, 0.0), (0.4, 0.0)], 0.1, [[0.05, 0.0], [0.15, 0.0], [0.25, 0.0], [0.35, 0.0]]),
        ([(0.0, 0.0), (0.0, 0.05)], 0.08, [[0.0, 0.025]]),
        ([(0.0, 0.0), (0.3, 0.0), (0.3, 0.1)], 0.2, [[0.1, 0.0], [0.3, 0.0]]),
    ]
    for points, spacing, expected in table:
        positions, segment_of = sample_positions(*chain(points), spacing)
        np.testing.assert_allclose(positions, expected, atol=1e-12)
        assert segment_of[0] == 0


@settings(derandomize=True, deadline=None, max_examples=60, print_blob=True)
@given(frontiers=st.lists(corners, min_size=1, max_size=4), spacing=st.floats(0.01, 0.5))
def test_every_frontier_has_floor_of_length_over_spacing_positions_at_least_one(frontiers, spacing):
    chains = [chain(points, i) for i, points in enumerate(frontiers)]
    segments, number = (np.concatenate([c[part] for c in chains]) for part in range(2))
    positions, segment_of = sample_positions(segments, number, spacing)
    lengths = np.hypot(*(segments[:, 2:] - segments[:, :2]).T)
    for i in range(len(frontiers)):
        cells = lengths[number == i].sum() / spacing
        count = (number[segment_of] == i).sum()
        assert max(1, np.floor(cells - 1e-6)) <= count <= max(1, np.floor(cells + 1e-6))
    ends = segments.reshape(-1, 2, 2)[segment_of]
    along = np.hypot(*(positions - ends[:, 0]).T) + np.hypot(*(positions - ends[:, 1]).T)
    np.testing.assert_allclose(along, lengths[segment_of], atol=1e-6)


def test_by_hand_each_position_at_rest_once_and_every_direction_of_its_segment_at_every_speed():
    directions = np.array([[True, False, True, False], [False, True, True, False]])
    position_of, velocities = product(directions, np.array([1, 0]), np.array([1, 2]), V_MAX)
    assert position_of.tolist() == [0, 0, 0, 1, 1, 1, 1, 1]
    first = [[0.0, 0.0], [0.0, 1.2], [-1.2, 0.0]]
    second = [[0.0, 0.0], [0.6, 0.0], [1.2, 0.0], [-0.6, 0.0], [-1.2, 0.0]]
    np.testing.assert_allclose(velocities, [*first, *second], atol=1e-12)


@settings(derandomize=True, deadline=None, max_examples=30, print_blob=True)
@given(n_directions=st.integers(4, 32), n_speeds=st.integers(1, 8))
def test_directions_do_not_repeat_and_no_speed_is_beyond_v_max(n_directions, n_speeds):
    """Theta without its last element, which as printed repeats the first."""
    directions = np.ones((1, n_directions), bool)
    _, velocities = product(directions, np.zeros(1, int), np.array([n_speeds]), V_MAX)
    assert len(velocities) == 1 + n_directions * n_speeds
    assert len(np.unique(velocities.round(9), axis=0)) == len(velocities)
    assert np.hypot(*velocities.T).max() == pytest.approx(V_MAX)


def test_by_hand_the_printed_speed_set_depends_on_the_frontiers_length():
    frontier_of = np.array([0, 0, 0, 1])
    assert SPEED_COUNTS["fixed"](frontier_of, 4).tolist() == [4, 4, 4, 4]
    assert SPEED_COUNTS["printed"](frontier_of, 4).tolist() == [3, 3, 3, 1]
