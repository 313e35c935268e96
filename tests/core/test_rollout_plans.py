"""Coarse and whole plans: what J is made of, refinement, rollouts in full, symmetry."""

from functools import cache

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from clearance_scenes import field_of, walls
from collplan_core.time_to_goal_planner.coarse_search import SWITCH_STEPS, coarse_plans, targets, to_go, toward
from collplan_core.time_to_goal_planner.full_plan import LATE, extend, near_at
from collplan_core.time_to_goal_planner.initial_plans import best_coarse, coarse_commands, padded, shifted, tracked
from collplan_core.time_to_goal_planner.model import KNOT, STEP, Scene
from collplan_core.time_to_goal_planner.refinement import refine
from collplan_core.time_to_goal_planner.sampling import in_full
from rollout_scenes import (
    RADIUS,
    SETTINGS,
    Rolled,
    faces_field,
    joined,
    law_and_price,
    open_field,
    pillars_field,
    rolled,
    scene_over,
    with_strategy,
)
from scenes import rotation, unit

FEW = settings(derandomize=True, deadline=None, max_examples=8, print_blob=True)
STRATEGIES = ("bounce", "tolerate", "avoid", "stop_guarantee")
N_STEPS = round(SETTINGS.time_to_goal.horizon / STEP)
SPEED = SETTINGS.robot.max_speed
U_TURN = walls((-1.2, -0.5), (1.0, -0.5), (1.0, 0.5), (-1.2, 0.5), (-1.2, -0.5)), walls((-1.2, 0.0), (0.5, 0.0))

FLOOR = shapely.LineString([(-2.0, -0.4 - RADIUS), (2.0, -0.4 - RADIUS)])
POSTS = ((0.0, 0.1, 0.15), (0.5, -0.2, 0.1))


@cache
def u_turn() -> Scene:
    """Along the lower row, round the septum's tip, and back along the upper one."""
    return scene_over(field_of(np.vstack(U_TURN)), (-0.9, 0.25))


@cache
def pillars() -> Scene:
    return scene_over(joined(pillars_field(*POSTS), faces_field((np.pi / 2, 0.4))), (1.2, 0.0))


@cache
def nothing() -> Scene:
    return scene_over(open_field(), (1.0, 0.0))


OBSTACLES = {
    u_turn: shapely.multilinestrings(np.vstack(U_TURN).reshape(-1, 2, 2)),
    pillars: shapely.union_all([*(shapely.Point(x, y).buffer(r, quad_segs=64).exterior for x, y, r in POSTS), FLOOR]),
    nothing: shapely.Polygon(),
}
CORNERS = shapely.multipoints(np.vstack(U_TURN).reshape(-1, 2))
PLACES = {u_turn: (-0.9, -0.25), pillars: (-0.6, 0.05), nothing: (-1.0, 0.0)}
scenes = st.sampled_from(sorted(PLACES, key=lambda scene: scene.__wrapped__.__name__))
velocities = st.tuples(st.floats(0.0, SPEED), st.floats(-np.pi, np.pi)).map(lambda v: v[0] * unit(v[1]))
strategies = st.sampled_from(STRATEGIES)


def begin_in(scene, velocity=(0.0, 0.0)) -> np.ndarray:
    return np.array([*PLACES[scene], *velocity], dtype=float)


def coarse(scene: Scene, strategy: str, begin: np.ndarray, stop_test: bool = False):
    law, price = law_and_price(with_strategy(strategy))
    first = np.array([*begin, near_at(scene, begin[0], begin[1]), 0.0])
    return coarse_plans(scene, law, price, first, N_STEPS, stop_test)


def extended(scene: Scene, strategy: str, begin: np.ndarray, commands, stop_test: bool = False, most: int = 160):
    law, price = law_and_price(with_strategy(strategy))
    start = rolled(scene, with_strategy(strategy), begin, commands, stop_test, most)
    if start.arrived:
        return start
    n = extend(scene, law, price, start.commands, start.n, start.states[start.n])
    return rolled(scene, with_strategy(strategy), begin, start.commands[:n], stop_test, most)


def refined(scene: Scene, strategy: str, plan: Rolled, seed: int, count: int, stop_test: bool = False) -> Rolled:
    law, price = law_and_price(with_strategy(strategy))
    commands, states, costs = plan.commands.copy(), plan.states.copy(), plan.costs.copy()
    random = np.random.default_rng(seed)
    n, j, _ = refine(scene, law, price, stop_test, random, count, commands, states, costs, plan.n, plan.j)
    return Rolled(commands, states, costs, n, j, plan.arrived)


def assert_same(one: Rolled, other: Rolled) -> None:
    assert (one.n, one.j) == (other.n, other.j)
    np.testing.assert_array_equal(one.commands[: one.n], other.commands[: one.n])
    np.testing.assert_array_equal(one.states[: one.n + 1], other.states[: one.n + 1])
    np.testing.assert_array_equal(one.costs[: one.n + 1], other.costs[: one.n + 1])


@FEW
@given(scene=scenes, v=velocities, strategy=strategies, seed=st.integers(0, 2**31), test=st.booleans())
def test_refinement_never_raises_j_and_says_what_its_commands_give(scene, v, strategy, seed, test):
    random = np.random.default_rng(seed)
    begin, commands = begin_in(scene, v), random.uniform(-0.8, 0.8, (25, 2))
    plan = extended(scene(), strategy, begin, commands, test)
    for stage in range(4):
        better = refined(scene(), strategy, plan, stage, 50, test)
        assert better.j <= plan.j
        assert np.hypot(*better.commands[: better.n].T).max() <= SPEED + 1e-9
        again = rolled(scene(), with_strategy(strategy), begin, better.commands[: better.n], test, 160)
        assert_same(again, better)
        plan = again


@pytest.mark.parametrize("scene", PLACES)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_refinement_makes_plans_faster(scene, strategy):
    """From anything at all to nearly what the best coarse plan leads to."""
    begin = begin_in(scene)
    velocities, j, _ = coarse(scene(), strategy, begin)
    ((a, b, c),) = best_coarse(j, 1)
    commands = np.zeros((N_STEPS // 2, 2))
    coarse_commands(commands, velocities[a], velocities[c], SWITCH_STEPS[b], N_STEPS)
    best = refined(scene(), strategy, extended(scene(), strategy, begin, commands), 0, 1200)
    plan = extended(scene(), strategy, begin, np.zeros((10, 2)))
    better = refined(scene(), strategy, plan, 0, 1200)
    assert better.j < plan.j - 0.3
    assert best.j - 0.2 < better.j < 1.3 * best.j


@pytest.mark.parametrize("scene", PLACES)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_the_best_coarse_plans_are_extended_to_the_goal(scene, strategy):
    velocities, j, _ = coarse(scene(), strategy, begin_in(scene))
    for a, b, c in best_coarse(j, SETTINGS.time_to_goal.n_starts):
        commands = np.zeros((N_STEPS // 2, 2))
        coarse_commands(commands, velocities[a], velocities[c], SWITCH_STEPS[b], N_STEPS)
        plan = extended(scene(), strategy, begin_in(scene), commands)
        assert plan.arrived


def test_nothing_is_tried_on_a_plan_without_knots_and_nothing_changes_where_nothing_is_tried():
    plan = extended(nothing(), "bounce", begin_in(nothing), np.zeros((5, 2)))
    assert_same(refined(nothing(), "bounce", plan, 0, 0), plan)
    empty = rolled(nothing(), with_strategy("bounce"), begin_in(nothing), np.zeros((0, 2)), most=10)
    assert_same(refined(nothing(), "bounce", empty, 0, 10), empty)


def test_equal_seeds_refine_alike():
    plan = extended(u_turn(), "bounce", begin_in(u_turn), np.zeros((5, 2)))
    one, other, third = (refined(u_turn(), "bounce", plan, seed, 200) for seed in (3, 3, 4))
    assert_same(one, other)
    assert third.j != one.j


@FEW
@given(scene=scenes, v=velocities, strategy=strategies, seed=st.integers(0, 2**31))
def test_j_is_the_time_and_what_is_paid_on_the_way(scene, v, strategy, seed):
    begin, commands = begin_in(scene, v), np.random.default_rng(seed).uniform(-0.8, 0.8, (20, 2))
    short = rolled(scene(), with_strategy(strategy), begin, commands)
    law = law_and_price(with_strategy(strategy))[0]
    if not short.arrived:
        rest = to_go(scene(), law, *short.states[short.n]) + LATE
        assert short.j == pytest.approx(short.n * KNOT + short.costs[short.n] + rest, abs=1e-12)
    there = extended(scene(), strategy, begin, commands)
    assert (np.diff(there.costs[: there.n + 1]) >= 0.0).all()
    if not there.arrived:
        return
    goal = scene().goal
    distances = np.hypot(there.states[:, 0] - goal.x, there.states[:, 1] - goal.y)[: there.n + 1]
    assert (distances[1:-1] > goal.tolerance).all()
    # the last knot ends where the robot arrives
    assert distances[-1] <= goal.tolerance
    assert (there.n - 1) * KNOT <= there.j - there.costs[there.n] <= there.n * KNOT


def test_by_hand_straight_across_an_open_floor():
    """From rest to the edge of the goal: the wheels' full acceleration, then full speed."""
    plan = rolled(nothing(), with_strategy("bounce"), begin_in(nothing), np.tile((SPEED, 0.0), (50, 1)))
    assert plan.arrived
    a, lag = SETTINGS.robot.max_acceleration, SETTINGS.robot.velocity_lag
    # a first-order lag behind full acceleration: 0.7 s and its distance, then v_max but for what the lag leaves
    begun, linear = (SPEED - a * lag) / a, a * lag
    lost = begun * SPEED - 0.5 * a * begun**2 + linear * lag
    assert plan.j == pytest.approx((2.0 - nothing().goal.tolerance + lost) / SPEED, abs=2e-3)
    assert plan.costs[plan.n] == 0.0


def test_a_plan_that_begins_at_the_goal_is_there_at_once():
    begin = np.array([0.95, 0.0, 0.0, 0.0])
    plan = rolled(nothing(), with_strategy("avoid"), begin, np.zeros((5, 2)))
    assert (plan.n, plan.j, plan.arrived) == (1, 0.0, True)


@FEW
@given(scene=scenes, v=velocities, strategy=strategies)
def test_coarse_plans_are_whole_plans_up_to_the_horizon(scene, v, strategy):
    begin = begin_in(scene, v)
    velocities, j, ends = coarse(scene(), strategy, begin)
    tried = np.isfinite(j)
    assert tried.sum() > 0.9 * 25 * (4 * 24 + 25)
    assert j[tried].min() > 0.0
    law = law_and_price(with_strategy(strategy))[0]
    for a, b, c in np.argwhere(tried)[:: tried.sum() // 40]:
        commands = np.zeros((N_STEPS // 2, 2))
        n = coarse_commands(commands, velocities[a], velocities[c], SWITCH_STEPS[b], N_STEPS)
        plan = rolled(scene(), with_strategy(strategy), begin, commands)
        if plan.arrived:
            # its own time and contacts; grazes are not charged to coarse plans
            assert (plan.n - 1) * KNOT <= j[a, b, c] <= plan.j + 1e-9
        else:
            np.testing.assert_array_equal(ends[a, b, c], plan.states[n])
            assert j[a, b, c] <= plan.j - LATE + 1e-9
            assert j[a, b, c] >= N_STEPS * STEP + to_go(scene(), law, *ends[a, b, c]) - 1e-9


def test_targets_are_rest_and_rings_at_full_and_half_speed():
    ring = targets(0.3, SPEED)
    speeds, counts = np.unique(np.round(np.hypot(*ring.T), 9), return_counts=True)
    np.testing.assert_allclose(speeds, (0.0, 0.5 * SPEED, SPEED))
    assert counts.tolist() == [1, 8, 16]
    np.testing.assert_allclose(ring[0], SPEED * unit(0.3))
    assert len(np.unique(np.round(ring, 9), axis=0)) == 25


def moved(scene: Scene, move: np.ndarray) -> Scene:
    """The u-turn turned and mirrored about the goal."""
    goal = np.array([scene.goal.x, scene.goal.y])
    segments = np.vstack(U_TURN).reshape(-1, 2) - goal
    return scene_over(field_of((segments @ move.T).reshape(-1, 4)), (0.0, 0.0))


@pytest.mark.parametrize("quarters", range(4))
@pytest.mark.parametrize("mirrored", [False, True])
def test_times_and_coarse_plans_turn_and_mirror_with_the_scene(quarters, mirrored):
    move = np.round(rotation(quarters * np.pi / 2)) @ np.diag([1.0, -1.0 if mirrored else 1.0])
    plain, other = moved(u_turn(), np.eye(2)), moved(u_turn(), move)
    law = law_and_price(with_strategy("bounce"))[0]
    for x, y, vx, vy in np.random.default_rng(0).uniform((-0.2, -0.65, -1, -1), (1.5, 0.1, 1, 1), (60, 4)):
        there = *(move @ (x, y)), *(move @ (vx, vy))
        assert to_go(other, law, *map(float, there)) == pytest.approx(to_go(plain, law, x, y, vx, vy), abs=1e-6)
        ux, uy, distance = toward(plain, x, y)
        assert toward(other, *map(float, there[:2])) == pytest.approx((*(move @ (ux, uy)), distance), abs=1e-6)
    begin = np.array([1.203, -0.507, 0.4, 0.1])
    one, two = (
        np.sort(j[np.isfinite(j)])
        for _, j, _ in (
            coarse(plain, "bounce", begin),
            coarse(other, "bounce", np.concatenate([move @ begin[:2], move @ begin[2:]])),
        )
    )
    assert one[0] == pytest.approx(two[0], abs=1e-6)
    # a few graze so that rounding decides whether they touch
    assert np.mean(np.abs(one - two) < 1e-6) > 0.97


@FEW
@given(scene=scenes, v=velocities, strategy=strategies, seed=st.integers(0, 2**31))
def test_a_plan_in_full_goes_through_its_knots_and_touches_obstacles(scene, v, strategy, seed):
    begin, commands = begin_in(scene, v), np.random.default_rng(seed).uniform(-0.8, 0.8, (20, 2))
    plan = extended(scene(), strategy, begin, commands)
    law = law_and_price(with_strategy(strategy))[0]
    rows, contacts = in_full(scene(), law, begin, plan.commands, plan.n, RADIUS)
    assert (np.diff(rows[:, 0]) > 1e-3).all()
    np.testing.assert_array_equal(rows[0], (0.0, *begin))
    for k in range(1, plan.n):
        at = int(np.argmin(np.abs(rows[:, 0] - k * KNOT)))
        assert rows[at, 0] == pytest.approx(k * KNOT, abs=1e-9)
        np.testing.assert_array_equal(rows[at, 1:], plan.states[k])
    np.testing.assert_array_equal(rows[-1, 1:], plan.states[plan.n])
    if plan.arrived:
        assert -STEP - 1e-9 <= plan.j - plan.costs[plan.n] - rows[-1, 0] <= 1e-9
    # no faster than the robot, through contacts too
    speeds = np.hypot(*np.diff(rows[:, 1:3], axis=0).T) / np.diff(rows[:, 0])
    assert speeds.max() <= SPEED + 0.15
    assert (np.diff(contacts[:, 0]) >= 0.0).all()
    assert len(contacts) == 0 or 0.0 <= contacts[0, 0] <= contacts[-1, 0] <= rows[-1, 0]
    for point in shapely.points(contacts[:, 1:3]):
        # at a tip and between two walls the normal is that of nodes 2 cm apart
        beside = CORNERS.distance(point) < 0.03
        assert OBSTACLES[scene].distance(point) < (0.03 if beside else 5e-3)


def test_by_hand_a_bounce_in_full():
    """Head-on at v_max into a wall 0.3 m away: there after 0.25 s, back at e v_max, at rest under the command 0."""
    scene = scene_over(faces_field((np.pi, 0.3)), (-1.2, 0.0))
    law = law_and_price(with_strategy("bounce"))[0]
    commands = np.repeat([(SPEED, 0.0), (-0.7 * SPEED, 0.0)], (5, 10), axis=0)
    rows, contacts = in_full(scene, law, np.array([0.0, 0.0, SPEED, 0.0]), commands, 15, RADIUS)
    np.testing.assert_allclose(contacts, [(0.25, 0.3 + RADIUS, 0.0, -0.7 * SPEED, 0.0)], atol=1e-3)
    assert rows[:, 1].max() == pytest.approx(0.3, abs=1e-3)
    np.testing.assert_allclose(rows[-1], (0.75, 0.3 - 0.5 * 0.7 * SPEED, 0.0, -0.7 * SPEED, 0.0), atol=2e-3)


def test_the_best_coarse_plans_begin_differently_and_come_in_order():
    j = np.random.default_rng(0).uniform(1.0, 2.0, (25, 5, 25))
    j[3] = np.inf
    j[7, 2, 4] = 0.5
    best = best_coarse(j, 6)
    assert best[0] == (7, 2, 4)
    assert len({a for a, _, _ in best}) == 6
    costs = [j[place] for place in best]
    assert costs == sorted(costs)
    assert [j[a].min() for a, _, _ in best] == costs
    assert len(best_coarse(j, 40)) == 25


def test_what_is_left_of_a_plan():
    commands = np.arange(20.0).reshape(10, 2)
    np.testing.assert_array_equal(shifted(commands, 0.0), commands)
    np.testing.assert_array_equal(shifted(commands, 3 * KNOT), commands[3:])
    np.testing.assert_array_equal(shifted(commands, 3.4 * KNOT), commands[3:])
    np.testing.assert_array_equal(shifted(commands, 3.6 * KNOT), commands[4:])
    assert len(shifted(commands, 10 * KNOT)) == len(shifted(commands, 1e6)) == 0
    assert len(shifted(np.zeros((0, 2)), 0.1)) == 0
    assert len(shifted(commands, -2 * KNOT)) <= 10
    np.testing.assert_array_equal(padded(commands, 12)[:10], commands)
    np.testing.assert_array_equal(padded(commands, 4), commands[:4])


def test_tracking_a_plan_from_where_it_is_changes_nothing_and_from_beside_leads_back():
    law, price = law_and_price(with_strategy("bounce"))
    begin = begin_in(nothing)
    plan = extended(nothing(), "bounce", begin, np.zeros((0, 2)))
    there = np.ascontiguousarray(plan.states[: plan.n, :2])
    same = tracked(nothing(), law, price, begin, plan.commands[: plan.n], there, 2.5)
    np.testing.assert_allclose(same, plan.commands[: plan.n], atol=1e-12)
    beside = begin + np.array([0.0, 0.05, 0.0, 0.0])
    back = tracked(nothing(), law, price, beside, plan.commands[: plan.n], there, 2.5)
    led = rolled(nothing(), with_strategy("bounce"), beside, back)
    alone = rolled(nothing(), with_strategy("bounce"), beside, plan.commands[: plan.n])
    assert abs(alone.states[alone.n, 1]) == pytest.approx(0.05, abs=1e-6)
    assert abs(led.states[led.n, 1]) < 0.01
