"""Both prunings, checked with shapely on maps of drawn worlds. Paper: II-C."""

import numpy as np
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from collplan_core.paper_planner.candidates import sample_positions
from collplan_core.paper_planner.pruning import free_sight, prune_directions, prune_positions
from scenes import SETTINGS, TURN, cluttered_worlds, free_polygon, map_of, star_map, unit

D_PRUNE, SPACING = SETTINGS.planner.prune_distance, SETTINGS.planner.frontier_spacing
GOALS = st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)).map(np.array)


def sampled(local_map) -> tuple[np.ndarray, np.ndarray]:
    positions, segment_of = sample_positions(local_map.segments, local_map.frontier_number, SPACING)
    return positions, local_map.frontier_number[segment_of]


def nearest_to_goal(positions, goal) -> float:
    return np.hypot(*(positions - goal).T).min()


def assert_stood_for(local_map, positions, frontier_of, kept, goal) -> None:
    """Each dropped frontier has a surviving one within d_prune, in free sight, nearer to the goal."""
    free = free_polygon(local_map).buffer(2e-3)
    for dropped in set(frontier_of[~kept]):
        assert not kept[frontier_of == dropped].any()
        mine = positions[frontier_of == dropped]
        standing = False
        for other in set(frontier_of[kept]):
            theirs = positions[frontier_of == other]
            if nearest_to_goal(theirs, goal) >= nearest_to_goal(mine, goal):
                continue
            pairs = [(a, b) for a in mine for b in theirs if np.hypot(*(a - b)) <= D_PRUNE + 1e-9]
            standing |= any(free.covers(shapely.LineString(pair)) for pair in pairs)
        assert standing


@given(world=cluttered_worlds(), goal=GOALS)
def test_a_dropped_frontier_is_stood_for_and_never_all_are_dropped(world, goal):
    local_map = map_of(world)
    assume(len(local_map.segments))
    positions, frontier_of = sampled(local_map)
    kept = prune_positions(local_map.border, positions, frontier_of, goal, D_PRUNE)
    assert kept.any()
    closest = min(set(frontier_of), key=lambda i: nearest_to_goal(positions[frontier_of == i], goal))
    assert kept[frontier_of == closest].all()
    assert_stood_for(local_map, positions, frontier_of, kept, goal)


@given(world=cluttered_worlds(), n_directions=st.integers(4, 32))
def test_a_step_from_a_frontier_leaves_f_in_the_directions_kept_alone(world, n_directions):
    local_map = map_of(world)
    for segment, kept in zip(local_map.segments, prune_directions(local_map.segments, n_directions), strict=True):
        along = segment[2:] - segment[:2]
        length = np.hypot(*along)
        if length < 0.01:
            continue
        middle = 0.5 * (segment[:2] + segment[2:])
        ways = np.array([unit(TURN * i / n_directions) for i in range(n_directions)])
        # along the frontier there is neither in nor out
        across = np.abs(along[0] * ways[:, 1] - along[1] * ways[:, 0]) / length > 0.05
        stays = local_map.contains(middle + 1e-3 * length * ways)
        np.testing.assert_array_equal(kept[across], ~stays[across])


OPEN = star_map(np.full(360, 1.0))
AHEAD = np.array([3.0, 0.0])


def test_by_hand_a_dropped_frontier_drops_nobody():
    """Three in a row toward the goal, 0.3 m apart: the middle one is stood for, the last by a dropped one only."""
    positions = np.array([[0.6, 0.0], [0.3, 0.0], [0.0, 0.0]])
    kept = prune_positions(OPEN.border, positions, np.array([0, 1, 2]), AHEAD, 0.35)
    assert kept.tolist() == [True, False, True]


def test_by_hand_a_frontier_across_unseen_space_is_kept():
    reach = np.full(360, 1.0)
    reach[10:21] = 0.1
    positions = np.array([0.5 * unit(0.0), 0.5 * unit(np.radians(30.0))])
    assert not free_sight(star_map(reach).border, *positions[0], *positions[1])
    assert prune_positions(star_map(reach).border, positions, np.array([0, 1]), AHEAD, 0.35).all()
    assert free_sight(OPEN.border, *positions[0], *positions[1])
    assert not prune_positions(OPEN.border, positions, np.array([0, 1]), AHEAD, 0.35).all()


def test_by_hand_directions_out_of_a_vertical_border():
    """Right border of the map, run upward: of eight directions the three with a part to the right stay."""
    kept = prune_directions(np.array([[0.6, -0.6, 0.6, 0.6]]), 8)
    assert np.flatnonzero(kept[0]).tolist() == [0, 1, 7]
