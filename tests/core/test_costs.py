"""The cost terms: worked by hand in the chosen reading and as printed, and under rotation and translation."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from collplan_core.paper_planner.costs.normalize import normalize
from collplan_core.paper_planner.costs.position import position_costs
from collplan_core.paper_planner.costs.risk import (
    collision_rate,
    crosses_boundary,
    distance_to_predicted,
    gap_risk,
    impact_distance,
)
from collplan_core.paper_planner.costs.total import (
    COLLISION_RISK,
    POSITION,
    REBOUND_REWARD,
    RISK,
    TOTAL,
    VELOCITY,
    choose,
    evaluate,
)
from collplan_core.paper_planner.costs.velocity import rebound_reward, velocity_cost
from scenes import rotation, star_map, unit

QUICK = settings(derandomize=True, deadline=None, max_examples=60, print_blob=True)
points = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0)).map(np.array)
angles = st.floats(-np.pi, np.pi)
shares = st.floats(0.0, 1.0)
seeds = st.integers(0, 2**32 - 1)

THRESHOLD, PENALTY = np.radians(70.0), 5.0
ORIGIN = np.zeros(2)


# J_pos, Alg. 1


def j_pos(positions, current, goal, aim, previous, travelled=0.0, has_previous=True, interior=False, printed=False):
    return position_costs(
        positions, current, goal, aim, previous, travelled, has_previous, THRESHOLD, PENALTY, interior, printed
    )


ABC = np.array([[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0]])
"""Ahead, left and behind of a robot at the origin with its goal at (1, 0): ways of 1, 0.5 + sqrt(1.25) and 2 m."""
LEFT = 0.5 + np.sqrt(1.25) - 1.0


def test_by_hand_position_costs_are_normalised_first_and_penalised_then():
    """The previous aim was to the left: ahead and behind are turns of 90 degrees."""
    costs = j_pos(ABC, ORIGIN, np.array([1.0, 0.0]), np.array([0.0, 1.0]), np.array([0.0, -0.3]))
    np.testing.assert_allclose(costs, [5.0 * (1 + 0) - 1, LEFT, 5.0 * (1 + 1) - 1])


def test_by_hand_position_costs_as_printed():
    """The interior angle at p_cur to p_pre = (0, -0.3) is 90, 180, 90 degrees: all penalised, then normalised."""
    costs = j_pos(
        ABC, ORIGIN, np.array([1.0, 0.0]), np.array([0.0, 1.0]), np.array([0.0, -0.3]), 0.3, interior=True, printed=True
    )
    np.testing.assert_allclose(costs, [0.0, LEFT, 1.0])


def test_by_hand_the_printed_order_squeezes_what_is_not_penalised():
    costs = j_pos(ABC, ORIGIN, np.array([1.0, 0.0]), np.array([1.0, 0.0]), ORIGIN, printed=True)
    spread = 5.0 * 2.0 - 1.0
    np.testing.assert_allclose(costs, [0.0, (5.0 * (1 + LEFT) - 1.0) / spread, 1.0])


def test_without_a_previous_plan_nothing_is_penalised():
    costs = j_pos(ABC, ORIGIN, np.array([1.0, 0.0]), np.full(2, np.nan), ORIGIN, has_previous=False)
    np.testing.assert_allclose(costs, [0.0, LEFT, 1.0])


def test_by_hand_the_turn_counts_from_its_threshold_on():
    positions = np.array([0.5 * unit(np.radians(a)) for a in (0.0, 69.9, 70.1, -70.1, 180.0)])
    plain = j_pos(positions, ORIGIN, np.array([3.0, 0.0]), np.array([1.0, 0.0]), ORIGIN, has_previous=False)
    costs = j_pos(positions, ORIGIN, np.array([3.0, 0.0]), np.array([1.0, 0.0]), ORIGIN)
    assert (costs > plain).tolist() == [False, False, True, True, True]


@QUICK
@given(seed=seeds, turn=angles, shift=points, mirror=st.booleans(), printed=st.booleans(), interior=st.booleans())
def test_position_costs_move_with_the_world(seed, turn, shift, mirror, printed, interior):
    positions, (current, goal, aim, previous) = np.split(np.random.default_rng(seed).normal(size=(12, 2)), [8])
    move = rotation(turn) @ np.diag([1.0, -1.0 if mirror else 1.0])
    costs = j_pos(positions, current, goal, aim, previous, 0.4, True, interior, printed)
    moved = j_pos(
        positions @ move.T + shift, move @ current + shift, move @ goal + shift, move @ aim, move @ previous + shift,
        0.4, True, interior, printed,
    )  # fmt: skip
    np.testing.assert_allclose(moved, costs, atol=1e-9)


@QUICK
@given(values=st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=20), scale=st.floats(0.1, 10.0))
def test_normalize_is_min_max_and_zero_without_spread(values, scale):
    values = np.array(values)
    shares_of = normalize(values)
    assert (shares_of >= 0.0).all()
    assert (shares_of <= 1.0).all()
    if np.ptp(values) > 1e-9:
        assert shares_of[np.argmin(values)] == 0.0
        assert shares_of[np.argmax(values)] == 1.0
        np.testing.assert_allclose(normalize(scale * values + 3.0), shares_of, atol=1e-6)
    elif np.ptp(values) == 0.0:
        assert not shares_of.any()


# J_risk, Alg. 2

WALL = np.array([[1.0, 0.0, 0.0, 1.0]])
"""A predicted boundary from (1, 0) upward."""


def test_by_hand_the_ray_meets_a_half_line_only_on_its_side():
    assert impact_distance(0.0, 0.5, 1.0, 0.0, WALL) == (pytest.approx(1.0), 0)
    assert impact_distance(0.0, -0.5, 1.0, 0.0, WALL)[1] == -1
    assert impact_distance(0.0, 0.5, -1.0, 0.0, WALL)[1] == -1
    assert impact_distance(0.0, 0.5, 0.0, 1.0, WALL)[1] == -1
    s = np.sqrt(0.5)
    assert impact_distance(0.0, 0.5, s, s, WALL)[0] == pytest.approx(np.sqrt(2.0))


def test_by_hand_the_first_of_several_half_lines_is_met():
    two = np.vstack([WALL, [[0.5, 0.0, 0.0, 1.0]]])
    assert impact_distance(0.0, 0.5, 1.0, 0.0, two) == (pytest.approx(0.5), 1)


def test_by_hand_distance_to_a_half_line():
    assert distance_to_predicted(0.0, 0.5, WALL) == pytest.approx(1.0)
    assert distance_to_predicted(0.0, -1.0, WALL) == pytest.approx(np.sqrt(2.0))
    assert distance_to_predicted(0.0, 0.0, np.zeros((0, 4))) == np.inf


def test_by_hand_the_collision_rate_is_one_over_the_time_to_collision():
    assert collision_rate(0.0, 0.5, 0.8, 0.0, WALL, 0.05, 0.05) == (pytest.approx(0.8), pytest.approx(1.0), 0)
    # at rest: nearest predicted boundary at the speed floor
    assert collision_rate(0.0, 0.5, 0.0, 0.0, WALL, 0.05, 0.05) == (pytest.approx(0.05), pytest.approx(1.0), -1)
    # nothing ahead
    assert collision_rate(0.0, 0.5, -0.8, 0.0, WALL, 0.05, 0.05)[0] == 0.0
    assert collision_rate(0.0, 0.5, 0.0, 0.0, np.zeros((0, 4)), 0.05, 0.05)[0] == 0.0
    # no time below the floor is told apart
    assert collision_rate(0.999, 0.5, 0.8, 0.0, WALL, 0.05, 0.05)[0] == pytest.approx(1 / 0.05)


@QUICK
@given(seed=seeds, turn=angles, shift=points, mirror=st.booleans(), at_rest=st.booleans())
def test_the_collision_rate_moves_with_the_world(seed, turn, shift, mirror, at_rest):
    rng = np.random.default_rng(seed)
    p, v, origins = rng.normal(size=2), rng.normal(size=2) * (not at_rest), rng.normal(size=(4, 2))
    tangents = np.array([unit(a) for a in rng.uniform(0, 6.28, 4)])
    move = rotation(turn) @ np.diag([1.0, -1.0 if mirror else 1.0])
    rate, distance, which = collision_rate(*p, *v, np.hstack([origins, tangents]), 0.05, 0.05)
    moved = collision_rate(
        *(move @ p + shift), *(move @ v), np.hstack([origins @ move.T + shift, tangents @ move.T]), 0.05, 0.05
    )
    assume(np.isfinite(distance) == np.isfinite(moved[1]))  # a half line's very end may be met or missed by rounding
    assert moved[0] == pytest.approx(rate, rel=1e-6, abs=1e-9)
    assert moved[2] == which


def test_by_hand_gap_risk_is_the_openings_width_at_the_candidate_or_the_bare_angle():
    """Open from 40 to 100 degrees, candidate at 60 degrees and 0.5 m: 40 degrees to the lit side."""
    reach = np.full(360, 0.2)
    reach[40:101] = 0.6
    x, y = 0.5 * unit(np.radians(60.0))
    angle = np.radians(40.0)
    assert gap_risk(reach, x, y, 0.5, False, True, 0.55, 0.8, 10.0, False) == pytest.approx(-0.8 * angle * 0.5)
    assert gap_risk(reach, x, y, 0.5, False, True, 0.55, 0.8, 10.0, True) == pytest.approx(-0.8 * angle)
    # what is wider than wide is not narrow
    assert gap_risk(reach, x, y, 0.5, False, True, 0.55, 0.8, 0.1, False) == pytest.approx(-0.8 * 0.1)


@QUICK
@given(seed=seeds, steps=st.integers(0, 359))
def test_gap_risk_turns_with_the_world(seed, steps):
    rng = np.random.default_rng(seed)
    reach = np.repeat(rng.uniform(0.2, 0.8, 36), 10)
    x, y = 0.5 * unit(rng.uniform(0, 6.28))
    arguments = (0.5, bool(rng.integers(2)), bool(rng.integers(2)), 0.55, 1.0, 10.0, False)
    moved = rotation(np.radians(steps)) @ [x, y]
    bearing = np.degrees(np.arctan2(y, x)) % 1.0
    assume(1e-6 < bearing < 1 - 1e-6)
    expected = gap_risk(reach, x, y, *arguments)
    assert gap_risk(np.roll(reach, steps), moved[0], moved[1], *arguments) == pytest.approx(expected, abs=1e-9)


def wall_ahead(steps: int = 0):
    """F of half a metre around, but a wall at x = 0.3 to the front, turned by whole degrees."""
    angles_of = 2 * np.pi * np.arange(360) / 360
    with np.errstate(divide="ignore"):
        wall = np.where(np.cos(angles_of) > 0.3, 0.3 / np.cos(angles_of), np.inf)
    reach = np.minimum(wall, 0.5)
    surface = np.where(wall < 0.5, 0, -1)
    return star_map(np.roll(reach, steps), np.roll(surface, steps))


@pytest.mark.parametrize("steps", [0, 37, 90, 181])
def test_by_hand_an_approach_through_an_observed_boundary_crosses_it(steps):
    local_map, r = wall_ahead(steps), rotation(np.radians(steps))

    def crosses(velocity, aim, position=(0.0, 0.0)) -> bool:
        f = local_map.ends, local_map.surface, local_map.shadow
        return crosses_boundary(*f, *(r @ position), *(r @ velocity), *(r @ aim), 1.2)

    assert not crosses([0.0, 0.0], [0.0, 0.45])  # beside the wall
    assert crosses([0.0, 0.0], [0.5, 0.1])  # behind it
    assert not crosses([0.0, 0.0], [0.25, 0.4], [0.25, 0.0])
    assert crosses([1.2, 0.0], [0.25, 0.4], [0.25, 0.0])  # the present speed carries it in
    assert not crosses([0.0, 0.0], [-0.7, 0.0])  # out of F where nothing was seen


# J_vel, eq. (2) and (3)

FAR_FREE, NEAR_FREE = star_map(np.full(360, 3.0)).ends, star_map(np.full(360, 0.2)).ends
UP = np.array([0.0, 1.0])


def test_by_hand_the_reward_of_a_rebound_into_the_unseen():
    """Square onto a wall 1 m ahead at 1 m/s: v_ref = -0.7 x; p_ref = (0.79, 0); goal ahead or behind."""
    head_on = (0.0, 0.0, 1.0, 0.0, 1.0, UP)
    assert rebound_reward(*head_on, 1.0, 0.0, NEAR_FREE, 0.7, 0.8, 0.3, -1.0) == pytest.approx(-0.7)
    assert rebound_reward(*head_on, -1.0, 0.0, NEAR_FREE, 0.7, 0.8, 0.3, -1.0) == pytest.approx(0.7)
    slanted = (0.0, 0.0, 1.0, 1.0, np.sqrt(2.0), UP)
    assert rebound_reward(*slanted, 0.0, 1.0, NEAR_FREE, 0.7, 0.8, 0.3, -1.0) == pytest.approx(0.8)


def test_by_hand_a_rebound_into_known_free_space_is_penalised():
    assert rebound_reward(0.0, 0.0, 1.0, 0.0, 1.0, UP, -1.0, 0.0, FAR_FREE, 0.7, 0.8, 0.3, -1.5) == -1.5
    # the horizon decides where it ends: 0.25 m of free space, left again after more than 0.25 / 0.7 s
    ends = star_map(np.full(360, 1.25)).ends
    assert rebound_reward(0.0, 0.0, 1.0, 0.0, 1.5, UP, -1.0, 0.0, ends, 0.7, 0.8, 0.3, -1.5) == pytest.approx(0.7)
    assert rebound_reward(0.0, 0.0, 1.0, 0.0, 1.5, UP, -1.0, 0.0, ends, 0.7, 0.8, 0.4, -1.5) == -1.5


@QUICK
@given(seed=seeds, steps=st.integers(0, 359), horizon=st.floats(0.05, 1.0))
def test_the_reward_turns_with_the_world(seed, steps, horizon):
    rng = np.random.default_rng(seed)
    reach = rng.uniform(0.4, 1.0, 360)
    p, v, tangent, goal = rng.normal(size=2), rng.normal(size=2), unit(rng.uniform(0, 6.28)), unit(rng.uniform(0, 6.28))
    r = rotation(np.radians(steps))
    rest = (0.7, 0.8, horizon, -1.0)
    expected = rebound_reward(*p, *v, 0.5, tangent, *goal, star_map(reach).ends, *rest)
    ends = star_map(np.roll(reach, steps)).ends
    moved = rebound_reward(*(r @ p), *(r @ v), 0.5, r @ tangent, *(r @ goal), ends, *rest)
    assert moved == pytest.approx(expected, abs=1e-9)


def test_by_hand_velocity_cost():
    assert velocity_cost(1.0, 0.5, 2.0, 1.0, 0.25, 0.4) == pytest.approx(-(2.0 + 0.5) * 0.75 - 0.4 * 0.25)
    assert velocity_cost(1.0, 0.5, 2.0, 1.0, 0.0, 9.0) == pytest.approx(-2.5)
    assert velocity_cost(1.0, 0.5, 2.0, 1.0, 1.0, 0.4) == pytest.approx(-0.4)


# eq. (1)

POSITIONS = np.array([[0.5, 0.2], [0.5, -0.2]])
AT = np.array([0, 0, 1])
VELOCITIES = np.array([[0.0, 0.0], [1.2, 0.0], [1.2, 0.0]])


def total(weights=(100.0, 0.1, 4.0), unit_vector=False, with_reward=True, with_factor=True):
    return evaluate(
        POSITIONS, AT, VELOCITIES, np.array([0.0, 1.0]), np.array([-0.3, -0.1]), np.array([0.0, 1.0]), ORIGIN,
        np.array([2.0, 0.0]), NEAR_FREE, np.array([[1.0, 0.0, 0.0, 1.0]]), np.array(weights), 0.05, 0.05, 0.7, 0.8,
        0.3, -1.0, unit_vector, with_reward, with_factor,
    )  # fmt: skip


def test_by_hand_the_terms_of_three_candidates():
    """At rest 0.5 m beside the wall: rate 0.1; at 1.2 m/s onto it: 2.4; past its end: 0."""
    terms = total()
    np.testing.assert_allclose(terms[:, COLLISION_RISK], [0.1 / 2.4, 1.0, 0.0])
    np.testing.assert_allclose(terms[:, POSITION], [0.0, 0.0, 1.0])
    np.testing.assert_allclose(terms[:, RISK], [0.1 / 2.4 - 0.3, 1.0 - 0.3, 0.0 - 0.1 + 1.0])
    np.testing.assert_allclose(terms[:, REBOUND_REWARD], [0.0, -0.7 * 1.2, 0.0])
    np.testing.assert_allclose(terms[:, VELOCITY], [0.0, 0.84, -1.2 * 2.0])
    np.testing.assert_allclose(
        terms[:, TOTAL], 100 * terms[:, POSITION] + 0.1 * terms[:, RISK] + 4 * terms[:, VELOCITY]
    )


def test_by_hand_the_options_of_the_velocity_cost():
    np.testing.assert_allclose(total(unit_vector=True)[:, VELOCITY], [0.0, 0.84, -1.2])
    np.testing.assert_allclose(total(with_reward=False)[:, VELOCITY], [0.0, 0.0, -2.4])
    np.testing.assert_allclose(total(with_factor=False)[:, VELOCITY], [0.0, -2.4 + 0.84, -2.4])


@QUICK
@given(w_p=st.floats(0, 100), w_r=st.floats(0, 100), w_v=st.floats(0, 100))
def test_the_total_is_the_weighted_sum_and_the_choice_its_least(w_p, w_r, w_v):
    terms = total((w_p, w_r, w_v))
    expected = w_p * terms[:, POSITION] + w_r * terms[:, RISK] + w_v * terms[:, VELOCITY]
    np.testing.assert_allclose(terms[:, TOTAL], expected, atol=1e-9)
    best = choose(terms, POSITIONS, AT, VELOCITIES, ORIGIN, 1.2, 0.0)
    assert terms[best, TOTAL] == terms[:, TOTAL].min()


def test_by_hand_equal_costs_are_told_apart_by_the_velocity_along_the_approach():
    even = np.zeros((3, 8))
    assert choose(even, POSITIONS, AT, VELOCITIES, ORIGIN, 1.2, 0.0) == 0
    assert choose(even, POSITIONS, AT, VELOCITIES, ORIGIN, 1.2, 1e-3) == 1
    # a difference greater than the tie's decides alone
    even[1:, TOTAL] = 2e-3
    assert choose(even, POSITIONS, AT, VELOCITIES, ORIGIN, 1.2, 1e-3) == 0
