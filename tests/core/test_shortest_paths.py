"""Shortest paths and the time to go: how long they are, what they keep clear of, where there is none."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.time_to_goal_planner.boundary_memory.clearance import clearance_at
from collplan_core.time_to_goal_planner.shortest_paths.cost_to_go import is_reachable
from collplan_core.time_to_goal_planner.shortest_paths.record import ShortestPaths
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from collplan_core.time_to_goal_planner.shortest_paths.waypoints import turn
from scenes import unit
from time_to_goal_scenes import (
    ACCELERATION,
    SETTINGS,
    SPEED,
    TOLERANCE,
    exact_lengths,
    path_length,
    to_go,
    toward,
    walls,
    walls_field,
)

QUICK = settings(max_examples=8)
GOAL = np.zeros(2)
coordinates = st.floats(-1.0, 1.0)
segments = st.tuples(coordinates, coordinates, coordinates, coordinates).filter(
    lambda s: np.hypot(s[2] - s[0], s[3] - s[1]) > 0.05
)
scenes = st.lists(segments, min_size=1, max_size=4).map(np.array)


def free_places(field, rng, n: int, at_least: float = 0.03) -> np.ndarray:
    places = rng.uniform(-1.3, 1.3, (8 * n, 2))
    clearance = [clearance_at(field.clearance, field.grid, *place) for place in places]
    return places[np.array(clearance) > at_least][:n]


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


SWING = SPEED / (2.0 * ACCELERATION)
"""Time that it costs to begin at rest, and to turn by a right angle at once [s]."""
wide = st.floats(-1.5, 1.5)
places = st.tuples(wide, wide).map(np.array)
angles = st.floats(-np.pi, np.pi)
velocities = st.tuples(st.floats(0.0, SPEED), angles).map(lambda v: v[0] * unit(v[1]))
SEPTUM = walls((-1.4, -0.4), (0.4, -0.4))
CLUTTER = np.vstack([SEPTUM, walls((0.3, 0.4), (0.9, 0.7)), walls((-0.8, 0.2), (-0.3, 0.9))])


def paths_to(goal, segments=CLUTTER) -> ShortestPaths:
    return shortest_paths(walls_field(segments), np.array(goal, dtype=float), np.array([1.0, 1.0]), SETTINGS)


AMONG_CLUTTER, IN_THE_OPEN = paths_to(GOAL), paths_to(GOAL, np.zeros((0, 4)))


@given(place=places, velocity=velocities, bearing=angles, share=st.floats(0.0, 0.999))
def test_it_is_never_less_than_the_straight_way_at_full_speed_and_0_only_within_the_tolerance(
    place, velocity, bearing, share
):
    time, distance = to_go(AMONG_CLUTTER, place, velocity), np.hypot(*place)
    assert time == 0.0 if distance < TOLERANCE else time >= distance / SPEED * (1 - 1e-12)
    assert to_go(AMONG_CLUTTER, share * TOLERANCE * unit(bearing), velocity) == 0.0


def test_by_hand_in_the_open():
    place = np.array([0.6, 0.0])
    assert to_go(IN_THE_OPEN, place) == pytest.approx(0.6 / SPEED + SWING)
    assert to_go(IN_THE_OPEN, place, (SPEED, 0.0)) == pytest.approx(0.6 / SPEED + 4.0 * SWING)
    assert to_go(IN_THE_OPEN, place, (0.0, SPEED)) == pytest.approx(0.6 / SPEED + 2.0 * SWING)
    np.testing.assert_allclose(toward(IN_THE_OPEN, place), (-1.0, 0.0, 0.6))


def test_a_turn_counts_by_its_angle_without_a_step():
    by_angle = [turn(np.cos(angle)) for angle in np.linspace(0.0, np.pi, 200)]
    assert np.all(np.diff(by_angle) >= 0.0)
    assert np.max(np.diff(by_angle)) < 0.02
    assert [turn(np.cos(a)) for a in (0.0, 0.5, np.pi)] == pytest.approx([0.0, 1.0 - np.cos(0.5), 1.5])


def test_a_u_turn_costs_the_same_however_many_waypoints_it_has():
    paths, beyond = paths_to((-0.4, -0.1)), np.array([0.3, -0.28])
    wx, wy, _ = toward(paths, beyond)
    for place in np.stack(np.meshgrid((-0.4, -0.2, 0.0), (-0.55, -0.7, -0.9)), axis=-1).reshape(-1, 2):
        ux, uy, _ = toward(paths, place)
        turns = to_go(paths, place, (SPEED * ux, SPEED * uy)) - path_length(paths, place) / SPEED
        assert turns == pytest.approx(SWING * turn(ux * wx + uy * wy), abs=0.05)
        assert turns > 0.9 * SWING
    assert to_go(paths, beyond, (SPEED * wx, SPEED * wy)) == pytest.approx(path_length(paths, beyond) / SPEED)


def test_a_robot_that_touches_a_wall_goes_from_the_free_cells_beside_it():
    touching, pressed = np.array([-0.5, -0.4 + 0.085]), np.array([-0.5, -0.4 + 0.05])
    paths = paths_to(GOAL)
    assert is_reachable(paths, touching)
    assert not is_reachable(paths, pressed)  # no free cell is beside it: way_to_goal takes it out of the wall first
    assert to_go(paths, touching) == pytest.approx(to_go(paths, np.array([-0.5, -0.4 + 0.105])), abs=0.03)
    assert np.isfinite(to_go(paths, pressed))


def test_where_the_goal_is_closed_off_there_is_no_time_and_no_direction():
    paths = paths_to(GOAL, walls((-0.4, -0.4), (0.4, -0.4), (0.4, 0.4), (-0.4, 0.4), (-0.4, -0.4)))
    assert is_reachable(paths, np.array([0.2, 0.0]))
    assert not is_reachable(paths, np.array([1.0, 0.0]))
    assert to_go(paths, (1.0, 0.0)) == np.inf
    assert toward(paths, (1.0, 0.0)) == (0.0, 0.0, np.inf)
    assert np.isfinite(to_go(paths, (0.2, 0.0)))
