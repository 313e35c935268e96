"""Shortest paths: how long they are, what they keep clear of, what they pass through."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import is_reachable
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from scenes import rotation
from time_to_goal_scenes import (
    SETTINGS,
    SPEED,
    TOLERANCE,
    exact_lengths,
    path_length,
    to_go,
    turned,
    walls,
    walls_field,
)

QUICK = settings(derandomize=True, deadline=None, max_examples=8, print_blob=True)
DISC = 2.0 * SETTINGS.robot.radius
GOAL = np.zeros(2)
coordinates = st.floats(-1.0, 1.0)
segments = st.tuples(coordinates, coordinates, coordinates, coordinates).filter(
    lambda s: np.hypot(s[2] - s[0], s[3] - s[1]) > 0.05
)
scenes = st.lists(segments, min_size=1, max_size=4).map(np.array)
angles = st.floats(-np.pi, np.pi)


def free_places(field, rng, n: int, at_least: float = 0.03) -> np.ndarray:
    """Up to n places of the arena that are clear."""
    places = rng.uniform(-1.3, 1.3, (8 * n, 2))
    clearance = [clearance_at(field.clearance, field.grid, *place) for place in places]
    return places[np.array(clearance) > at_least][:n]


def room_with(gap: np.ndarray) -> np.ndarray:
    """A closed room behind x = 0 but for a gap (n, 4) that begins and ends at y = +-0.7."""
    return np.vstack([gap, walls((0.0, 0.7), (-1.0, 0.7), (-1.0, -0.7), (0.0, -0.7))])


def opening(width: float) -> np.ndarray:
    return room_with(np.vstack([walls((0.0, 0.7), (0.0, width / 2)), walls((0.0, -width / 2), (0.0, -0.7))]))


def corridor(width: float) -> np.ndarray:
    half = width / 2
    return room_with(
        np.vstack([walls((0.0, 0.7), (0.0, half), (0.5, half)), walls((0.5, -half), (0.0, -half), (0.0, -0.7))])
    )


def passes(scene: np.ndarray, angle: float, shift: tuple[float, float]) -> bool:
    """Whether a path leads out of a room, turned and shifted."""

    def moved(place):
        return rotation(angle) @ place + shift

    field = walls_field(turned(scene, rotation(angle)) + np.tile(shift, 2))
    paths = shortest_paths(field, moved([-0.45, 0.1]), moved([0.8, 0.2]), SETTINGS)
    return is_reachable(paths, moved([0.8, 0.2]))


@QUICK
@given(
    angle=angles,
    shift=st.tuples(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03)),
    shape=st.sampled_from([opening, corridor]),
)
def test_a_passage_a_little_wider_than_the_disc_is_open_and_a_narrower_one_closed_at_any_angle(angle, shift, shape):
    assert passes(shape(DISC + 0.08), angle, shift)
    assert passes(shape(DISC + 0.06), angle, shift)
    assert not passes(shape(DISC - 0.01), angle, shift)


@QUICK
@given(scene=scenes, seed=st.integers(0, 99))
def test_lengths_are_those_of_the_visibility_graph(scene, seed):
    field = walls_field(scene)
    goal, *places = free_places(field, np.random.default_rng(seed), 12)
    paths = shortest_paths(field, goal, places[0], SETTINGS)
    far = paths.origin + paths.spacing * np.array(paths.length.shape)
    places = np.array([place for place in places if np.all((paths.origin < place) & (place < far))])
    # a passage less than 4 cm wider than the disc may count as closed
    through, around = (exact_lengths(scene, goal, places, SETTINGS.robot.radius + margin) for margin in (0.0, 0.02))
    for place, length, detour in zip(places, through, around, strict=True):
        found = path_length(paths, place)
        assert 0.99 * length - 0.01 <= found or (np.isinf(length) and np.isinf(found))
        assert found <= max(1.02 * length, detour) + 0.02


def test_paths_are_kept_until_something_changes():
    wall = walls((-0.5, 0.5), (0.5, 0.5))
    earlier = shortest_paths(walls_field(wall), GOAL, GOAL, SETTINGS)
    assert shortest_paths(walls_field(wall), GOAL.copy(), np.array([0.1, 0.1]), SETTINGS, earlier) is earlier
    longer = walls_field(np.vstack([wall, walls((0.5, 0.5), (0.6, 0.5))]))
    assert shortest_paths(longer, GOAL, GOAL, SETTINGS, earlier) is not earlier
    assert shortest_paths(walls_field(wall), GOAL + 0.01, GOAL, SETTINGS, earlier) is not earlier
    closer = SETTINGS.with_values({"planner.goal_tolerance": 0.05})
    assert shortest_paths(walls_field(wall), GOAL, GOAL, closer, earlier).tolerance == 0.05


def test_a_goal_that_is_closed_off_has_no_paths():
    room = walls((-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4), (-0.4, -0.4))
    paths = shortest_paths(walls_field(room), GOAL, np.array([1.0, 0.0]), SETTINGS)
    assert not is_reachable(paths, np.array([1.0, 0.0]))
    assert is_reachable(paths, np.array([0.2, 0.0]))
    assert path_length(paths, (1.0, 0.0)) == np.inf


def test_a_goal_too_near_to_a_wall_is_reached_as_nearly_as_the_disc_can():
    wall, beside = walls((-0.5, 0.05), (0.5, 0.05)), np.array([0.0, -0.5])
    paths = shortest_paths(walls_field(wall), GOAL, beside, SETTINGS)
    assert is_reachable(paths, beside)
    assert to_go(paths, beside, (0.0, SPEED)) == pytest.approx(0.5 / SPEED)
    assert to_go(paths, (0.0, -TOLERANCE + 0.001)) == 0.0
    behind = np.array([0.0, 0.3])
    assert path_length(paths, behind) > 1.2
    within = shortest_paths(walls_field(np.vstack([wall, walls((-0.5, -0.05), (0.5, -0.05))])), GOAL, beside, SETTINGS)
    assert not is_reachable(within, beside)


def test_a_goal_far_from_everything_known_is_gone_to_straight():
    for goal in [(6.0, 0.3), (0.5, -7.0)]:
        field, start = walls_field(walls((-0.5, 0.5), (-0.5, 1.0))), np.array([0.6, 0.4])
        paths = shortest_paths(field, np.array(goal), start, SETTINGS)
        straight = np.hypot(*(np.array(goal) - start))
        assert to_go(paths, start, SPEED * (np.array(goal) - start) / straight) == pytest.approx(straight / SPEED), goal


def test_a_goal_very_far_away_takes_larger_cells_not_more():
    field = walls_field(walls((-0.5, 0.5), (0.5, 0.5)))
    paths = shortest_paths(field, np.array([60.0, 40.0]), GOAL, SETTINGS)
    assert paths.length.size < 70_000
    assert paths.spacing > SETTINGS.time_to_goal.grid_spacing
    assert is_reachable(paths, GOAL)


def test_from_where_nothing_is_known_and_the_cells_end_the_way_is_straight():
    paths = shortest_paths(walls_field(np.zeros((0, 4))), GOAL, np.array([1.0, 0.0]), SETTINGS)
    assert to_go(paths, (5.0, 5.0), (-0.6, -0.6)) >= np.hypot(5.0, 5.0) / SPEED
    assert np.isfinite(to_go(paths, (5.0, 5.0)))
