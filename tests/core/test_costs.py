"""Candidates S x Theta x V, both prunings, and the cost terms in the chosen reading and as printed. Paper: II-C."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from collplan_core.paper_planner.candidates import long_enough, product, sample_positions
from collplan_core.paper_planner.costs import total
from collplan_core.paper_planner.costs.model import CostModel
from collplan_core.paper_planner.costs.position import position_costs, straight_on
from collplan_core.paper_planner.costs.risk import (
    collision_rate,
    collision_risks,
    contact_distance,
    crossings,
    distance_to_predicted,
    gap_risks,
)
from collplan_core.paper_planner.costs.total import TIE_BREAK, TOTAL, least_first, least_forward, weighted_terms
from collplan_core.paper_planner.costs.velocity import (
    rebound_reward,
    rebound_rewards,
    unit_vector,
    velocity_costs,
)
from collplan_core.paper_planner.pruning import prune_directions, prune_positions
from collplan_core.paper_planner.sampling_space import PRUNE_DISTANCE
from collplan_core.reflection import Ring
from collplan_core.velocity_bounds import velocity_bounds
from scenes import SETTINGS, TURN, cluttered_worlds, free_polygon, map_of, rotation, star_map, unit

BOUNDS = velocity_bounds(SETTINGS.robot)
THRESHOLD, PENALTY = np.radians(70.0), 5.0
ORIGIN = np.zeros(2)
MODEL = CostModel(
    position_weight=100.0,
    risk_weight=0.1,
    velocity_weight=4.0,
    speed_floor=0.05,
    time_floor=0.05,
    ring=Ring(0.7, 0.12, 1.0 / 3.0),
    rebound_horizon=0.3,
    rebound_penalty=-1.0,
)


# J_pos, Alg. 1


def j_pos(positions, current, goal, aimed, previous, travelled=0.0, turn_angle="turn", order="normalised_first"):
    """J_pos where the plan made at `previous` aimed along `aimed`."""
    onward = straight_on(previous, previous + aimed, current, ORIGIN, turn_angle == "printed")
    printed = order == "printed"
    return position_costs(positions, current, goal, onward, travelled, THRESHOLD, PENALTY, printed)


NO_PLAN = np.full(2, np.nan)
ABC = np.array([[0.5, 0.0], [0.0, 0.5], [-0.5, 0.0]])
"""Ahead, left and behind of a robot at the origin with its goal at (1, 0): ways of 1, 0.5 + sqrt(1.25) and 2 m."""
LEFT = 0.5 + np.sqrt(1.25) - 1.0


def test_by_hand_position_costs_are_normalised_first_and_penalised_then_or_as_printed():
    """As printed the interior angle at p_cur to p_pre = (0, -0.3) is 90, 180, 90 degrees: all are penalised."""
    goal, aimed, previous = np.array([1.0, 0.0]), np.array([0.0, 1.0]), np.array([0.0, -0.3])
    np.testing.assert_allclose(j_pos(ABC, ORIGIN, goal, aimed, previous), [5.0 * (1 + 0) - 1, LEFT, 5.0 * (1 + 1) - 1])
    printed = j_pos(ABC, ORIGIN, goal, aimed, previous, 0.3, "printed", "printed")
    np.testing.assert_allclose(printed, [0.0, LEFT, 1.0])
    costs = j_pos(ABC, ORIGIN, goal, goal, ORIGIN, order="printed")
    np.testing.assert_allclose(costs, [0.0, (5.0 * (1 + LEFT) - 1.0) / 9.0, 1.0])
    for turn_angle in ("turn", "printed"):
        costs = j_pos(ABC, ORIGIN, goal, NO_PLAN, previous, turn_angle=turn_angle)
        np.testing.assert_allclose(costs, [0.0, LEFT, 1.0])


def test_by_hand_the_turn_counts_from_its_threshold_on():
    positions = np.array([0.5 * unit(np.radians(a)) for a in (0.0, 69.9, 70.1, -70.1, 180.0)])
    plain = j_pos(positions, ORIGIN, np.array([3.0, 0.0]), NO_PLAN, ORIGIN)
    costs = j_pos(positions, ORIGIN, np.array([3.0, 0.0]), np.array([1.0, 0.0]), np.array([0.2, 0.5]))
    assert (costs > plain).tolist() == [False, False, True, True, True]


# J_risk, Alg. 2

WALL = np.array([[1.0, 0.0, 0.0, 1.0]])
"""A predicted boundary from (1, 0) upward."""


def test_by_hand_the_ray_meets_the_first_half_line_and_only_on_its_side():
    assert contact_distance(0.0, 0.5, 1.0, 0.0, WALL) == (pytest.approx(1.0), 0)
    for y, vx, vy in ((-0.5, 1.0, 0.0), (0.5, -1.0, 0.0), (0.5, 0.0, 1.0)):
        assert contact_distance(0.0, y, vx, vy, WALL)[1] == -1
    s = np.sqrt(0.5)
    assert contact_distance(0.0, 0.5, s, s, WALL)[0] == pytest.approx(np.sqrt(2.0))
    two = np.vstack([WALL, [[0.5, 0.0, 0.0, 1.0]]])
    assert contact_distance(0.0, 0.5, 1.0, 0.0, two) == (pytest.approx(0.5), 1)
    assert distance_to_predicted(0.0, 0.5, WALL) == pytest.approx(1.0)
    assert distance_to_predicted(0.0, -1.0, WALL) == pytest.approx(np.sqrt(2.0))
    assert distance_to_predicted(0.0, 0.0, np.zeros((0, 4))) == np.inf


def test_by_hand_the_collision_rate_is_one_over_the_time_to_collision():
    assert collision_rate(0.0, 0.5, 0.8, 0.0, WALL, MODEL) == (pytest.approx(0.8), pytest.approx(1.0), 0)
    # at rest: nearest predicted boundary at the speed floor
    assert collision_rate(0.0, 0.5, 0.0, 0.0, WALL, MODEL) == (pytest.approx(0.05), pytest.approx(1.0), -1)
    # nothing ahead
    assert collision_rate(0.0, 0.5, -0.8, 0.0, WALL, MODEL)[0] == 0.0
    assert collision_rate(0.0, 0.5, 0.0, 0.0, np.zeros((0, 4)), MODEL)[0] == 0.0
    # no time below the floor is told apart
    assert collision_rate(0.999, 0.5, 0.8, 0.0, WALL, MODEL)[0] == pytest.approx(1 / 0.05)


def gap_risk(reach, position, sides, widest=10.0, reading="opening_width") -> float:
    """J_risk,g at a position seen from the centre of F, with f_theta = 0.8."""
    printed = reading == "printed"
    return gap_risks(reach, position[None], np.array([sides]), ORIGIN, 0.55, 0.8, widest, printed)[0]


def test_by_hand_gap_risk_is_the_openings_width_at_the_candidate_or_the_bare_angle():
    reach = np.full(360, 0.2)
    reach[40:101] = 0.6
    position, angle = 0.5 * unit(np.radians(60.0)), np.radians(40.0)
    assert gap_risk(reach, position, (False, True)) == pytest.approx(-0.8 * angle * 0.5)
    assert gap_risk(reach, position, (False, True), reading="printed") == pytest.approx(-0.8 * angle)
    # what is wider than wide is not narrow
    assert gap_risk(reach, position, (False, True), widest=0.1) == pytest.approx(-0.8 * 0.1)


def wall_ahead(steps: int = 0):
    """F of half a metre around, but a wall at x = 0.3 to the front, turned by whole degrees."""
    angles_of = 2 * np.pi * np.arange(360) / 360
    with np.errstate(divide="ignore"):
        wall = np.where(np.cos(angles_of) > 0.3, 0.3 / np.cos(angles_of), np.inf)
    reach = np.minimum(wall, 0.5)
    surface = np.where(wall < 0.5, 0, -1)
    return star_map(np.roll(reach, steps), np.roll(surface, steps))


def test_by_hand_an_approach_through_an_observed_boundary_crosses_it():
    table = [
        ([0.0, 0.0], [0.0, 0.45], [0.0, 0.0], False),  # beside the wall
        ([0.0, 0.0], [0.5, 0.1], [0.0, 0.0], True),  # behind it
        ([0.0, 0.0], [0.25, 0.4], [0.25, 0.0], False),
        ([1.2, 0.0], [0.25, 0.4], [0.25, 0.0], True),  # the present speed carries it in
        ([0.0, 0.0], [-0.7, 0.0], [0.0, 0.0], False),  # out of F where nothing was seen
    ]
    for steps in (0, 37, 90, 181):
        local_map, r = wall_ahead(steps), rotation(np.radians(steps))
        f = local_map.border, local_map.surface, local_map.shadow
        for velocity, aim, position, crosses in table:
            where = (r @ aim)[None], r @ position, r @ velocity, BOUNDS
            assert crossings(*f, *where)[0] == crosses, (steps, velocity, aim)


# J_vel, eq. (2) and (3)

FAR_FREE, NEAR_FREE = star_map(np.full(360, 3.0)).border, star_map(np.full(360, 0.2)).border
ALONG_X, UP = np.array([1.0, 0.0]), np.array([0.0, 1.0])


def test_by_hand_the_reward_of_a_rebound_into_the_unseen():
    """Square onto a wall 1 m ahead at 1 m/s: v_ref = -0.7 x; p_ref = (0.79, 0); goal ahead or behind."""
    assert rebound_reward(1.0, 0.0, 1.0, 0.0, UP, NEAR_FREE, ALONG_X, MODEL) == pytest.approx(-0.7)
    assert rebound_reward(1.0, 0.0, 1.0, 0.0, UP, NEAR_FREE, -ALONG_X, MODEL) == pytest.approx(0.7)
    assert rebound_reward(1.0, 1.0, 1.0, 1.0, UP, NEAR_FREE, UP, MODEL) == pytest.approx(0.796)


def test_by_hand_a_rebound_into_known_free_space_is_penalised():
    model = MODEL._replace(rebound_penalty=-1.5)
    assert rebound_reward(1.0, 0.0, 1.0, 0.0, UP, FAR_FREE, -ALONG_X, model) == -1.5
    # the horizon decides where it ends: 0.25 m of free space, left again after more than 0.25 / 0.7 s
    border, later = star_map(np.full(360, 1.25)).border, model._replace(rebound_horizon=0.4)
    assert rebound_reward(1.5, 0.0, 1.0, 0.0, UP, border, -ALONG_X, model) == pytest.approx(0.7)
    assert rebound_reward(1.5, 0.0, 1.0, 0.0, UP, border, -ALONG_X, later) == -1.5


# eq. (1)

POSITIONS = np.array([[0.5, 0.2], [0.5, -0.2]])
POSITION_OF = np.array([0, 0, 1])
POINTS = POSITIONS[POSITION_OF]
VELOCITIES = np.array([[0.0, 0.0], [1.2, 0.0], [1.2, 0.0]])


def terms_of(model=MODEL, goal_vector="printed", rebound_reward=True, collision_factor=True):
    """The terms of three candidates before a predicted wall, the goal at (2, 0)."""
    collision_risk, distance, line = collision_risks(POINTS, VELOCITIES, WALL, model)
    to_goal = np.array([2.0, 0.0])
    reward = rebound_rewards(POINTS, VELOCITIES, distance, line, WALL, NEAR_FREE, to_goal, model)
    reward *= rebound_reward
    toward = unit_vector(to_goal) if goal_vector == "unit" else to_goal
    velocity_cost = velocity_costs(VELOCITIES, toward, collision_risk, reward, collision_factor)
    position_cost, gap_risk, approach_risk = np.array([0.0, 1.0]), np.array([-0.3, -0.1]), np.array([0.0, 1.0])
    return weighted_terms(
        POSITION_OF, position_cost, gap_risk, approach_risk, collision_risk, reward, velocity_cost, model
    )


def test_by_hand_the_terms_of_three_candidates():
    """At rest 0.5 m beside the wall: rate 0.1; at 1.2 m/s onto it: 2.4; past its end: 0."""
    terms = terms_of()
    np.testing.assert_allclose(terms[:, total.COLLISION_RISK], [0.1 / 2.4, 1.0, 0.0])
    np.testing.assert_allclose(terms[:, total.POSITION], [0.0, 0.0, 1.0])
    np.testing.assert_allclose(terms[:, total.RISK], [0.1 / 2.4 - 0.3, 1.0 - 0.3, 0.0 - 0.1 + 1.0])
    np.testing.assert_allclose(terms[:, total.REBOUND_REWARD], [0.0, -0.7 * 1.2, 0.0])
    np.testing.assert_allclose(terms[:, total.VELOCITY], [0.0, 0.84, -1.2 * 2.0])
    np.testing.assert_allclose(
        terms[:, TOTAL], 100 * terms[:, total.POSITION] + 0.1 * terms[:, total.RISK] + 4 * terms[:, total.VELOCITY]
    )


def test_by_hand_the_options_of_the_velocity_cost():
    np.testing.assert_allclose(terms_of(goal_vector="unit")[:, total.VELOCITY], [0.0, 0.84, -1.2])
    np.testing.assert_allclose(terms_of(rebound_reward=False)[:, total.VELOCITY], [0.0, 0.0, -2.4])
    np.testing.assert_allclose(terms_of(collision_factor=False)[:, total.VELOCITY], [0.0, -2.4 + 0.84, -2.4])


def test_by_hand_equal_costs_are_told_apart_by_the_velocity_along_the_approach():
    even = np.zeros((3, 8))[:, TOTAL]
    assert least_first(even, POINTS, VELOCITIES, ORIGIN, 1.2) == 0
    assert least_forward(even, POINTS, VELOCITIES, ORIGIN, 1.2) == 1
    # a difference greater than the tie's decides alone
    even[1:] = 2 * TIE_BREAK
    assert least_forward(even, POINTS, VELOCITIES, ORIGIN, 1.2) == 0
    assert least_first(np.array([1.0, -1.0, 0.0]), POINTS, VELOCITIES, ORIGIN, 1.2) == 1


def chain(points, number: int = 0) -> tuple[np.ndarray, np.ndarray]:
    points = np.array(points, dtype=float)
    return np.hstack([points[:-1], points[1:]]), np.full(len(points) - 1, number)


def test_by_hand_short_frontiers_are_passed_over_where_a_longer_one_is_seen():
    chains = chain([(0.0, 0.0), (0.03, 0.0)], 0), chain([(0.0, 1.0), (0.04, 1.0), (0.08, 1.0)], 1)
    segments, number = (np.concatenate(part) for part in zip(*chains, strict=True))
    assert long_enough(segments, number, 0.05).tolist() == [False, True, True]
    assert long_enough(segments, number, 0.1).all()  # no longer one is seen
    assert long_enough(segments, number, 0.0).all()  # as printed


def test_by_hand_positions_are_the_centres_of_equal_cells():
    table = [
        ([(0.0, 0.0), (0.4, 0.0)], 0.1, [[0.05, 0.0], [0.15, 0.0], [0.25, 0.0], [0.35, 0.0]]),
        ([(0.0, 0.0), (0.0, 0.05)], 0.08, [[0.0, 0.025]]),
        ([(0.0, 0.0), (0.39, 0.0)], 0.1, [[0.065, 0.0], [0.195, 0.0], [0.325, 0.0]]),
        ([(0.0, 0.0), (0.3, 0.0), (0.3, 0.1)], 0.2, [[0.1, 0.0], [0.3, 0.0]]),
    ]
    for points, spacing, expected in table:
        positions, segment_of = sample_positions(*chain(points), spacing)
        np.testing.assert_allclose(positions, expected, atol=1e-12)
        assert segment_of[0] == 0


def test_by_hand_each_position_at_rest_once_and_every_direction_of_its_segment_at_every_speed():
    directions = np.array([[True, False, True, False], [False, True, True, False]])
    position_of, velocities = product(directions, np.array([1, 0]), np.array([1, 2]), BOUNDS)
    assert position_of.tolist() == [0, 0, 0, 1, 1, 1, 1, 1]
    first = [[0.0, 0.0], [0.0, 1.2], [-1.2, 0.0]]
    second = [[0.0, 0.0], [0.6, 0.0], [1.2, 0.0], [-0.6, 0.0], [-1.2, 0.0]]
    np.testing.assert_allclose(velocities, [*first, *second], atol=1e-12)


D_PRUNE, SPACING = PRUNE_DISTANCE, SETTINGS.planner.frontier_spacing
GOALS = st.tuples(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0)).map(np.array)


def nearest_to_goal(positions, goal) -> float:
    return np.hypot(*(positions - goal).T).min()


def assert_stood_for(local_map, positions, frontier_of, kept, goal) -> None:
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
    positions, segment_of = sample_positions(local_map.segments, local_map.frontier_number, SPACING)
    frontier_of = local_map.frontier_number[segment_of]
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
