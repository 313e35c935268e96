"""Coarse and full plans: what their cost is made of, refinement, trajectories, symmetry."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.time_to_goal_planner.arrival import UNREACHED_COST, least_time, to_go
from collplan_core.time_to_goal_planner.boundary_memory.clearance import OBSERVED, PENDING
from collplan_core.time_to_goal_planner.full_plan import SHORTEST, FullPlan, sample_trajectory
from collplan_core.time_to_goal_planner.initial_plans import (
    CoarsePlans,
    best_coarse,
    coarse_commands,
    coarse_plans,
    extended,
    padded,
    targets,
)
from collplan_core.time_to_goal_planner.model import CONTROL_INTERVAL, STEP, Problem, problem_of
from collplan_core.time_to_goal_planner.plan_cycle import HORIZON, N_STARTS
from collplan_core.time_to_goal_planner.refinement import refine
from collplan_core.time_to_goal_planner.shortest_paths.search import shortest_paths
from scenes import unit
from time_to_goal_scenes import (
    BOUNDS,
    RADIUS,
    SETTINGS,
    SPEED,
    faces_field,
    has_arrived,
    joined,
    motion_in,
    of_strategy,
    open_field,
    pillars_field,
    problem_over,
    rolled,
    walls,
    walls_field,
    with_strategy,
)

FEW = settings(derandomize=True, deadline=None, max_examples=8, print_blob=True)
STRATEGIES = ("bounce", "tolerate", "avoid", "stop_guarantee")
N_STEPS = round(HORIZON / STEP)
MOST = 160
"""Control intervals that a plan has room for."""
U_TURN = walls((-1.2, -0.5), (1.0, -0.5), (1.0, 0.5), (-1.2, 0.5), (-1.2, -0.5)), walls((-1.2, 0.0), (0.5, 0.0))

POSTS = ((0.0, 0.1, 0.15), (0.5, -0.2, 0.1))


@cache
def u_turn() -> Problem:
    return problem_over(walls_field(np.vstack(U_TURN)), (-0.9, 0.25))


@cache
def pillars() -> Problem:
    """Beside a wall that was seen just now: contacts early in a plan are others than late ones."""
    wall = faces_field((np.pi / 2, 0.4), source=PENDING)
    return problem_over(joined(pillars_field(*POSTS), wall), (1.2, 0.0))


@cache
def nothing() -> Problem:
    return problem_over(open_field(), (1.0, 0.0))


PLACES = {u_turn: (-0.9, -0.25), pillars: (-0.6, 0.05), nothing: (-1.0, 0.0)}
scenes = st.sampled_from(sorted(PLACES, key=lambda scene: scene.__wrapped__.__name__))
velocities = st.tuples(st.floats(0.0, SPEED), st.floats(-np.pi, np.pi)).map(lambda v: v[0] * unit(v[1]))
strategies = st.sampled_from(STRATEGIES)


def state_in(scene, velocity=(0.0, 0.0)) -> np.ndarray:
    return np.array([*PLACES[scene], *velocity], dtype=float)


def coarse_in(problem: Problem, state: np.ndarray, best: float = np.inf, margin: float = np.inf) -> CoarsePlans:
    initial = motion_in(problem, state)
    return coarse_plans(problem, initial, targets(problem, initial), N_STEPS, best, margin)


def carried_on(problem: Problem, state: np.ndarray, commands) -> FullPlan:
    return extended(problem, motion_in(problem, state), padded(np.array(commands), MOST), len(commands))


def refined(problem: Problem, plan: FullPlan, seed: int, count: int) -> FullPlan:
    copy = plan._replace(commands=plan.commands.copy(), states=plan.states.copy(), costs=plan.costs.copy())
    return refine(problem, copy, count, np.random.default_rng(seed))


def assert_same(one: FullPlan, other: FullPlan) -> None:
    assert (one.n, one.cost) == (other.n, other.cost)
    np.testing.assert_array_equal(one.commands[: one.n], other.commands[: one.n])
    np.testing.assert_array_equal(one.states[: one.n + 1], other.states[: one.n + 1])
    np.testing.assert_array_equal(one.costs[: one.n + 1], other.costs[: one.n + 1])


@FEW
@given(scene=scenes, v=velocities, strategy=strategies, seed=st.integers(0, 2**31), test=st.booleans())
def test_refinement_never_raises_the_cost_and_says_what_its_commands_give(scene, v, strategy, seed, test):
    random = np.random.default_rng(seed)
    problem, state = of_strategy(scene(), strategy, test), state_in(scene, v)
    plan = carried_on(problem, state, random.uniform(-0.8, 0.8, (25, 2)))
    for stage in range(4):
        better = refined(problem, plan, stage, 50)
        assert better.cost <= plan.cost
        assert np.hypot(*better.commands[: better.n].T).max() <= SPEED + 1e-9
        again = rolled(problem, state, better.commands[: better.n], MOST)
        assert_same(again, better)
        plan = again


@pytest.mark.parametrize("scene", PLACES)
def test_refinement_makes_plans_faster(scene):
    for strategy in STRATEGIES:
        problem, state = of_strategy(scene(), strategy), state_in(scene)
        coarse, started = coarse_in(problem, state), []
        for place in best_coarse(coarse.costs, N_STARTS):
            commands, _ = coarse_commands(coarse, place, N_STEPS, N_STEPS // 2)
            started.append(carried_on(problem, state, commands))
            assert has_arrived(problem, started[-1])
        best = refined(problem, started[0], 0, 1200)
        plan = carried_on(problem, state, np.zeros((10, 2)))
        better = refined(problem, plan, 0, 1200)
        assert better.cost < plan.cost - 0.3
        assert best.cost - 0.2 < better.cost < 1.3 * best.cost


@FEW
@given(scene=scenes, v=velocities, strategy=strategies, seed=st.integers(0, 2**31))
def test_the_cost_is_the_time_and_what_is_paid_on_the_way(scene, v, strategy, seed):
    problem, state = of_strategy(scene(), strategy), state_in(scene, v)
    commands, goal = np.random.default_rng(seed).uniform(-0.8, 0.8, (20, 2)), problem.constants.goal
    short = rolled(problem, state, commands)
    if not has_arrived(problem, short):
        rest = to_go(problem, motion_in(problem, short.states[short.n])) + UNREACHED_COST
        assert short.cost == pytest.approx(short.n * CONTROL_INTERVAL + short.costs[short.n] + rest, abs=1e-12)
    there = carried_on(problem, state, commands)
    assert (np.diff(there.costs[: there.n + 1]) >= 0.0).all()
    if not has_arrived(problem, there):
        return
    distances = np.hypot(there.states[:, 0] - goal.x, there.states[:, 1] - goal.y)[: there.n + 1]
    assert (distances[1:-1] > goal.tolerance).all()
    # the last control interval ends where the robot arrives
    assert distances[-1] <= goal.tolerance
    assert (there.n - 1) * CONTROL_INTERVAL <= there.cost - there.costs[there.n] <= there.n * CONTROL_INTERVAL


def test_by_hand_straight_across_an_open_floor():
    plan = rolled(nothing(), state_in(nothing), np.tile((SPEED, 0.0), (50, 1)))
    assert has_arrived(nothing(), plan)
    a, lag = SETTINGS.robot.max_acceleration, SETTINGS.robot.velocity_lag
    # a first-order lag behind full acceleration: 0.7 s and its distance, then v_max but for what the lag leaves
    begun, linear = (SPEED - a * lag) / a, a * lag
    lost = begun * SPEED - 0.5 * a * begun**2 + linear * lag
    assert plan.cost == pytest.approx((2.0 - nothing().constants.goal.tolerance + lost) / SPEED, abs=2e-3)
    assert plan.costs[plan.n] == 0.0
    there = rolled(of_strategy(nothing(), "avoid"), (0.95, 0.0, 0.0, 0.0), np.zeros((5, 2)))
    assert (there.n, there.cost, has_arrived(nothing(), there)) == (1, 0.0, True)  # it begins at the goal


@FEW
@given(scene=scenes, v=velocities, strategy=strategies)
def test_coarse_plans_are_full_plans_up_to_the_horizon(scene, v, strategy):
    problem, state = of_strategy(scene(), strategy), state_in(scene, v)
    coarse = coarse_in(problem, state)
    tried = np.isfinite(coarse.costs)
    assert tried.sum() > 0.9 * 25 * (4 * 24 + 25)
    assert coarse.costs[tried].min() > 0.0
    for place in map(tuple, np.argwhere(tried)[:: tried.sum() // 40]):
        commands, n = coarse_commands(coarse, place, N_STEPS, N_STEPS // 2)
        plan, cost = rolled(problem, state, commands), coarse.costs[place]
        if has_arrived(problem, plan):
            # its own time and contacts; near misses are not charged to coarse plans
            assert (plan.n - 1) * CONTROL_INTERVAL <= cost <= plan.cost + 1e-9
        else:
            np.testing.assert_allclose(coarse.ends[place], plan.states[n], rtol=0.0, atol=1e-9)
            assert cost <= plan.cost - UNREACHED_COST + 1e-9
            assert cost >= N_STEPS * STEP + to_go(problem, motion_in(problem, coarse.ends[place])) - 1e-9


@FEW
@given(scene=scenes, v=velocities, strategy=strategies, better=st.floats(0.0, 0.5), margin=st.floats(0.0, 1.0))
def test_only_coarse_plans_beyond_the_margin_are_given_up(scene, v, strategy, better, margin):
    problem, state = of_strategy(scene(), strategy), state_in(scene, v)
    everyone = coarse_in(problem, state).costs
    for best in (np.inf, everyone.min() - better):
        left = coarse_in(problem, state, best, margin).costs
        kept = np.isfinite(left)
        np.testing.assert_array_equal(left[kept], everyone[kept])
        # at the horizon the time to go is more than what is left at the least
        within = everyone <= min(best, everyone.min()) + margin - 1e-9
        assert kept[within].all()
    state = state_in(nothing)
    everyone = coarse_in(nothing(), state).costs
    left = coarse_in(nothing(), state, everyone.min(), 0.2).costs
    assert 0 < np.isfinite(left).sum() < 0.5 * np.isfinite(everyone).sum()  # and most of them on an open floor


def test_by_hand_the_least_time_round_a_tip_is_that_of_the_path():
    problem = u_turn()
    paths, goal = problem.paths, problem.constants.goal

    def least(y: float) -> float:
        return least_time(paths.length, paths.cells, goal, BOUNDS, motion_in(problem, (-0.9, y, 0.0, 0.0)))

    # 1.4 m along the lower row, half a turn of the disc round the tip, and back to the goal
    expected = (1.4 + np.pi * RADIUS + 1.4 - goal.tolerance) / SPEED
    assert expected - 0.2 < least(-0.11) < expected
    # inside the septum no path is known
    assert least(-0.03) == pytest.approx((0.28 - goal.tolerance) / SPEED, abs=1e-9)


def test_a_goal_that_is_as_near_through_a_wall_is_not_said_to_be_a_long_way_round():
    wide = with_strategy("bounce", planner__goal_tolerance=1.0)
    field, goal = walls_field(np.vstack(U_TURN)), np.array([-0.9, 0.25])
    problem = problem_of(field, field.clearance >= 0.0, shortest_paths(field, goal, goal, wide), wide)
    paths, disc = problem.paths, problem.constants.goal
    assert disc.longest_within > 2.0 > disc.tolerance == 0.7
    for x in (-0.9, -0.3, 0.3):
        here = motion_in(problem, (x, -0.25, 0.0, 0.0))
        straight = np.hypot(x + 0.9, 0.5) - disc.tolerance
        assert least_time(paths.length, paths.cells, disc, BOUNDS, here) == pytest.approx(straight / SPEED, abs=1e-9)
    narrow = u_turn().constants.goal
    assert narrow.tolerance <= narrow.longest_within < narrow.tolerance + SETTINGS.time_to_goal.grid_spacing


@FEW
@given(scene=scenes, v=velocities, strategy=strategies, seed=st.integers(0, 2**31))
def test_a_trajectory_goes_through_the_states_of_its_plan(scene, v, strategy, seed):
    problem, state = of_strategy(scene(), strategy), state_in(scene, v)
    plan = carried_on(problem, state, np.random.default_rng(seed).uniform(-0.8, 0.8, (20, 2)))
    rows, contacts = sample_trajectory(problem, motion_in(problem, state), plan.commands[: plan.n], RADIUS)
    assert (np.diff(rows[:, 0]) > 0.99 * SHORTEST * STEP).all()
    np.testing.assert_array_equal(rows[0], (0.0, *state))
    for k in range(1, plan.n):
        at = int(np.argmin(np.abs(rows[:, 0] - k * CONTROL_INTERVAL)))
        assert rows[at, 0] == pytest.approx(k * CONTROL_INTERVAL, abs=1e-9)
        np.testing.assert_array_equal(rows[at, 1:], plan.states[k])
    np.testing.assert_array_equal(rows[-1, 1:], plan.states[plan.n])
    if has_arrived(problem, plan):
        assert -STEP - 1e-9 <= plan.cost - plan.costs[plan.n] - rows[-1, 0] <= 1e-9
    # no faster than the robot, through contacts too
    speeds = np.hypot(*np.diff(rows[:, 1:3], axis=0).T) / np.diff(rows[:, 0])
    assert speeds.max() <= SPEED + 0.15
    assert (np.diff(contacts[:, 0]) >= 0.0).all()
    assert len(contacts) == 0 or 0.0 <= contacts[0, 0] <= contacts[-1, 0] <= rows[-1, 0]


def test_by_hand_the_trajectory_of_a_bounce():
    """Head-on at v_max into a wall 0.3 m away: there after 0.25 s, back at e v_max, at rest under the command 0."""
    problem = problem_over(faces_field((np.pi, 0.3)), (-1.2, 0.0))
    commands = np.repeat([(SPEED, 0.0), (-0.7 * SPEED, 0.0)], (5, 10), axis=0)
    rows, contacts = sample_trajectory(problem, motion_in(problem, (0.0, 0.0, SPEED, 0.0)), commands, RADIUS)
    expected = 0.25, 0.3 + RADIUS, 0.0, -0.7 * SPEED, 0.0, -1.0, 0.0, SPEED, OBSERVED
    np.testing.assert_allclose(contacts, [expected], atol=1e-3)
    assert rows[:, 1].max() == pytest.approx(0.3, abs=1e-3)
    np.testing.assert_allclose(rows[-1], (0.75, 0.3 - 0.5 * 0.7 * SPEED, 0.0, -0.7 * SPEED, 0.0), atol=2e-3)
