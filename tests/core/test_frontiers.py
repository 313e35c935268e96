"""Surfaces and frontiers of hand-made scenes, at many and at few beams."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from collplan_core.local_map.free_space import MAP_BORDER
from collplan_core.local_map.frontiers import BORDER_RUN, SHADOW_EDGE
from scenes import HALF_SIDE, RADIUS, box, map_of, rotation, unit, world_of

BEAMS = [30, 60, 360, 1000]


def edges(local_map) -> np.ndarray:
    return local_map.segments[local_map.frontier_kind == SHADOW_EDGE]


@pytest.mark.parametrize("n_beams", BEAMS)
@settings(derandomize=True, deadline=None, max_examples=25, print_blob=True)
@given(distance=st.floats(0.1, 0.65), tilt=st.floats(-np.pi, np.pi))
def test_a_long_wall_is_one_surface_without_a_false_frontier(n_beams, distance, tilt):
    """However flat the beams graze it; at 30 beams from 0.2 m on: nearer, one wall in seventy has a false one."""
    assume(n_beams >= 60 or distance >= 0.2)
    wall = box(-8.0, distance, 8.0, distance + 0.2) @ rotation(tilt).T
    local_map = map_of(world_of([wall]), n_beams=n_beams)
    assert len(edges(local_map)) == 0
    assert set(local_map.surface) == {MAP_BORDER, 0}
    assert len(set(local_map.frontier_number)) == 1
    assert len(local_map.observed_boundaries()) == 1


@pytest.mark.parametrize("n_beams", BEAMS)
@pytest.mark.parametrize("turn", np.radians([0.0, 17.0, 90.0, 200.0]))
def test_a_corridor_has_a_frontier_at_each_end_and_none_along_its_walls(n_beams, turn):
    walls = [box(-4.0, 0.15, 4.0, 0.3) @ rotation(turn).T, box(-4.0, -0.3, 4.0, -0.15) @ rotation(turn).T]
    local_map = map_of(world_of(walls), n_beams=n_beams)
    assert len(edges(local_map)) == 0
    assert len(set(local_map.frontier_number)) == 2
    middles = [
        local_map.segments[local_map.frontier_number == i].reshape(-1, 2).mean(axis=0) for i in (0, 1)
    ]  # fmt: skip
    sides = sorted(m @ unit(turn) for m in middles)
    assert sides[0] < -0.5
    assert sides[1] > 0.5


@pytest.mark.parametrize("n_beams", [60, 360, 1000])
def test_a_gap_between_two_pillars_is_a_frontier_of_its_own(n_beams):
    pillars = [box(0.3, 0.15, 0.4, 0.9), box(0.3, -0.9, 0.4, -0.15)]
    local_map = map_of(world_of(pillars), n_beams=n_beams)
    through = [s for s, k in zip(local_map.segments, local_map.frontier_kind, strict=True)
               if k == BORDER_RUN and np.allclose(s[[0, 2]], HALF_SIDE) and abs(s[1] + s[3]) < 0.05]  # fmt: skip
    assert len(through) == 1
    # the disc's centre sees the border between the two grown corners
    beside = edges(local_map)
    assert len(beside[(beside[:, [0, 2]].min(axis=1) > 0.2) & (np.abs(beside[:, [1, 3]]).max(axis=1) < 0.2)]) == 2


def test_a_gap_too_narrow_for_the_disc_is_none():
    pillars = [box(0.3, RADIUS - 0.01, 0.4, 0.9), box(0.3, -0.9, 0.4, -RADIUS + 0.01)]
    local_map = map_of(world_of(pillars))
    assert (local_map.border_points[np.abs(local_map.border_points[:, 1]) < 0.5][:, 0] < 0.4).all()


def test_by_hand_a_pillar_before_a_wall():
    """Pillar at x = 0.2, wall at x = 0.5: a shadow edge from each of the pillar's grown corners to the grown wall."""
    local_map = map_of(world_of([box(0.2, -0.05, 0.3, 0.05), box(0.5, -3.0, 0.6, 3.0)]))
    upper = edges(local_map)[np.argmax(edges(local_map)[:, 3])]
    # tangent from the origin to the grown corner (0.2, 0.05) is the lowest free direction
    d = np.hypot(0.2, 0.05)
    bearing = np.arctan2(0.05, 0.2) + np.arcsin(RADIUS / d)
    np.testing.assert_allclose(upper[:2], np.sqrt(d**2 - RADIUS**2) * unit(bearing), atol=0.03)
    assert upper[2] == pytest.approx(0.41, abs=1e-9)
    assert upper[3] == pytest.approx(0.41 * np.tan(bearing), abs=0.015)
    lower = edges(local_map)[np.argmin(edges(local_map)[:, 3])]
    np.testing.assert_allclose(lower, [upper[2], -upper[3], upper[0], -upper[1]], atol=1e-9)


def test_the_open_side_of_a_shadow_edge_is_the_farther_one():
    local_map = map_of(world_of([box(0.2, -0.05, 0.3, 0.05), box(0.5, -3.0, 0.6, 3.0)]))
    sides = local_map.open_side[local_map.frontier_kind == SHADOW_EDGE]
    for segment, (clockwise, counter_clockwise) in zip(edges(local_map), sides, strict=True):
        # clockwise lies the first end, counter-clockwise the second
        first, second = np.hypot(*segment[:2]), np.hypot(*segment[2:])
        assert clockwise == (first > second)
        assert counter_clockwise == (second > first)
    assert local_map.open_side[local_map.frontier_kind == BORDER_RUN].all()


def test_frontiers_run_counter_clockwise_and_those_of_one_number_follow_each_other():
    local_map = map_of(world_of([box(0.2, -0.05, 0.3, 0.05)]))
    cross = local_map.segments[:, 0] * local_map.segments[:, 3] - local_map.segments[:, 1] * local_map.segments[:, 2]
    assert (cross > -1e-9).all()
    for number in set(local_map.frontier_number):
        of_one = local_map.segments[local_map.frontier_number == number]
        np.testing.assert_allclose(of_one[1:, :2], of_one[:-1, 2:], atol=1e-12)


@pytest.mark.parametrize("gap", [0.001, 0.02, 0.2])
@pytest.mark.parametrize("n_beams", [60, 360, 1000])
def test_a_round_pillar_however_near_has_a_shadow_edge_on_each_side(gap, n_beams):
    local_map = map_of(world_of(circles=[(RADIUS + gap + 0.25, 0.0, 0.25)]), n_beams=n_beams)
    kinds = [len(set(local_map.frontier_number[local_map.frontier_kind == k])) for k in (SHADOW_EDGE, BORDER_RUN)]
    assert kinds == [2, 1]
    assert len(local_map.predicted) == 0
