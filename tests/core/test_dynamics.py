"""One step of the robot's dynamics: the first contact in it, what contacts cost, whether it could stop."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.reflection import Ring, rebound
from collplan_core.time_to_goal_planner.arrival import BRAKING_SHARE, UNSTOPPABLE, admits_stop
from collplan_core.time_to_goal_planner.boundary_memory.clearance import INFERRED, OBSERVED, PENDING, clearance_at
from collplan_core.time_to_goal_planner.dynamics import NO_CONTACT, SLIDES, Contact, Motion, contact_cost, margin_cost
from collplan_core.time_to_goal_planner.model import (
    AVERSE_COSTS,
    CONTROL_INTERVAL,
    IMPACT_SPEED,
    INFERRED_COST,
    STEP,
    Problem,
    RobotModel,
    contact_costs,
    robot_model,
)
from collplan_core.time_to_goal_planner.plan_cycle import LONGEST_PLAN
from scenes import rotation, unit
from time_to_goal_scenes import (
    RADIUS,
    SETTINGS,
    SPEED,
    faces_field,
    joined,
    motion_in,
    of_strategy,
    open_field,
    pillars_field,
    problem_over,
    rolled,
    stepped,
    walls,
    walls_field,
    with_strategy,
)

FEW = settings(max_examples=15)
MODEL = robot_model(with_strategy("bounce"))
angles = st.floats(-np.pi, np.pi)
shares = st.floats(0.0, 1.0)
rings = st.builds(Ring, shares, st.floats(0.0, 1.0), st.floats(0.05, 0.5), st.just(1.0))
velocities = st.tuples(st.floats(0.0, SPEED), angles).map(lambda v: v[0] * unit(v[1]))
incidences = st.floats(np.radians(-75.0), np.radians(75.0))
HALF = 0.3
ROOM = problem_over(faces_field(*((k * np.pi / 2, HALF) for k in range(4)), half_side=0.5), (0.0, 0.0))
"""The disc's centre stays within |x|, |y| <= HALF."""


def coasting(ring: Ring = MODEL.ring) -> RobotModel:
    """A robot without wheels: nothing but boundaries changes its velocity."""
    return MODEL._replace(wheels=MODEL.wheels._replace(max_acceleration=1e-15), ring=ring)


def with_model(problem: Problem, model: RobotModel) -> Problem:
    return problem._replace(constants=problem.constants._replace(model=model))


def one_wall(bearing: float, source: int = OBSERVED):
    """A wall that the disc's centre touches at the origin; its normal points along the bearing."""
    return problem_over(faces_field((bearing, 0.0), source=source, half_side=0.3), 0.25 * unit(bearing))


WALLS = [(bearing, one_wall(bearing)) for bearing in (0.0, 0.37, np.pi / 2, 2.5, -1.2)]
some_walls = st.sampled_from(WALLS)


def at_wall(bearing: float, incidence: float, speed: float, share: float) -> np.ndarray:
    velocity = speed * (rotation(incidence) @ -unit(bearing))
    return np.array([*(-share * STEP * velocity), *velocity])


@given(wall=some_walls, incidence=incidences, speed=st.floats(0.4, SPEED), share=st.floats(0.0, 0.95), ring=rings)
def test_a_contact_is_the_rebound_and_the_rest_of_the_step_goes_on_from_it(wall, incidence, speed, share, ring):
    bearing, problem = wall
    begin = at_wall(bearing, incidence, speed, share)
    ((motion, contact),) = stepped(with_model(problem, coasting(ring)), begin, [(0.0, 0.0)])
    expected = rebound(begin[2:], unit(bearing), ring)
    assert contact.kind == OBSERVED
    assert contact.normal_speed == pytest.approx(speed * np.cos(incidence), abs=1e-9)
    assert contact.share == pytest.approx(share, abs=2e-2 if share < 0.05 else 1e-9)
    np.testing.assert_allclose(contact[3:], unit(bearing), atol=1e-9)
    np.testing.assert_allclose(motion[2:4], expected, atol=1e-9)
    np.testing.assert_allclose(motion[:2], (1.0 - contact.share) * STEP * expected, atol=5e-4)


commands = st.lists(st.tuples(velocities, st.integers(1, 12)), min_size=3, max_size=8).map(
    lambda parts: np.repeat([u for u, _ in parts], [count for _, count in parts], axis=0)
)
places = st.tuples(st.floats(-HALF, HALF), st.floats(-HALF, HALF))


def rows_of(steps) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Motions (n, 5), kinds of contact (n,), and the contacts' speed, share and normal (n, 4)."""
    motions, contacts = (np.array([step[k] for step in steps]) for k in (0, 1))
    return motions, contacts[:, 0], contacts[:, 1:]


@FEW
@given(begin=places, v=velocities, u=commands, ring=rings)
def test_no_contact_gives_energy_and_none_leads_through_a_wall(begin, v, u, ring):
    model = MODEL._replace(ring=ring)
    rows, kinds, contacts = rows_of(stepped(with_model(ROOM, model), [*begin, *v], u))
    before = np.vstack([v, rows[:-1, 2:4]])
    # a driven step ends between the velocity it has and the commanded one
    assert (np.hypot(*rows[:, 2:4].T) <= np.maximum(np.hypot(*before.T), np.hypot(*u.T)) + 1e-9).all()
    assert np.abs(rows[:, :2]).max() <= HALF + 1e-9
    assert (contacts[np.isin(kinds, (OBSERVED, INFERRED)), 0] > IMPACT_SPEED).all()
    assert (contacts[kinds == SLIDES, 0] <= IMPACT_SPEED).all()
    assert (contacts[kinds == NO_CONTACT] == 0.0).all()


CLUTTER = problem_over(
    joined(
        faces_field((0.0, 0.8), (np.pi / 2, 0.8), (np.pi, 0.8), (-np.pi / 2, 0.8), half_side=1.0),
        pillars_field((0.3, 0.3, 0.12), (-0.3, 0.25, 0.05), (0.1, -0.45, 0.2), half_side=1.0),
    ),
    (0.7, 0.7),
)


@FEW
@given(v=velocities, u=commands)
def test_what_is_said_of_the_clearance_is_never_too_much(v, u):
    rows, kinds, _ = rows_of(stepped(CLUTTER, [-0.05, 0.0, *v], u))
    there = [clearance_at(CLUTTER.clearance, CLUTTER.constants.grid, x, y) for x, y in rows[:, :2]]
    assert min(there) > -1e-3
    assert (rows[:, 4] <= np.array(there) + 1e-3).all()
    free = kinds == NO_CONTACT
    assert (rows[free, 4] <= np.array(there)[free] + 1e-9).all()


def test_a_slow_contact_slides_and_inferred_solid_takes_the_speed_into_it():
    for share, kind in ((0.9, SLIDES), (1.1, OBSERVED)):
        begin = [0.0005, 0.0, -share * IMPACT_SPEED, 0.5]
        ((motion, contact),) = stepped(with_model(WALLS[0][1], coasting()), begin, [(0.0, 0.0)])
        assert contact.kind == kind
        if kind == SLIDES:
            np.testing.assert_allclose(motion[2:4], (0.0, 0.5), atol=1e-9)
    problem = with_model(one_wall(0.0, INFERRED), coasting())
    ((motion, contact),) = stepped(problem, at_wall(0.0, 0.5, 1.0, 0.5), [(0.0, 0.0)])
    assert contact.kind == INFERRED
    dull = MODEL.ring._replace(restitution=0.0)
    np.testing.assert_allclose(motion[2:4], rebound(np.array([-np.cos(0.5), -np.sin(0.5)]), unit(0.0), dull))


def test_by_hand_what_is_pending_is_met_as_inferred_solid_until_it_will_have_stood():
    """From 0.6 s of the plan on, 24 steps: 0.25 s to stand and 0.35 s to turn off if it does not."""
    problem, begin = with_model(one_wall(0.0, PENDING), coasting()), at_wall(0.0, 0.5, 1.0, 0.5)
    for begun, kind in ((0, INFERRED), (23, INFERRED), (24, OBSERVED), (80, OBSERVED)):
        (expected,), (found,) = (
            stepped(with_model(one_wall(0.0, kind), coasting()), begin, [(0.0, 0.0)], begun),
            stepped(problem, begin, [(0.0, 0.0)], begun),
        )
        assert found == expected, begun
        assert (found[1].kind, found[0].steps) == (kind, begun + 1)
    slower = robot_model(with_strategy("bounce", movers__standing_time=1.0))
    assert slower.stood_by == pytest.approx(MODEL.stood_by + 0.75)


def test_from_inside_a_wall_the_robot_comes_out_at_once():
    for deep in (0.001, 0.01, 0.04, 0.08):
        for velocity in ((0.0, 0.0), (-1.2, 0.0), (1.2, 0.0), (0.0, 1.0)):
            ((motion, contact),) = stepped(WALLS[0][1], [-deep, 0.0, *velocity], [(0.0, 0.0)])
            assert np.isfinite([*motion, *contact]).all()
            assert motion.x >= -1e-9
            assert motion.vx >= 0.0


def cost_of(costs, kind: int, normal_speed: float) -> float:
    return contact_cost(costs, Contact(kind, normal_speed, 0.5, 1.0, 0.0))


def test_what_a_contact_costs():
    bounce, tolerate, avoid = (contact_costs(with_strategy(name)) for name in ("bounce", "tolerate", "avoid"))
    p = SETTINGS.time_to_goal
    assert cost_of(bounce, OBSERVED, 1.0) == pytest.approx(p.hit_cost)
    assert cost_of(tolerate, OBSERVED, 1.0) == 0.0
    assert cost_of(avoid, OBSERVED, 0.5) == pytest.approx(AVERSE_COSTS[0] + 0.5 * AVERSE_COSTS[1])
    assert cost_of(bounce, INFERRED, 1.0) == cost_of(tolerate, INFERRED, 1.0) == pytest.approx(INFERRED_COST)
    assert cost_of(avoid, INFERRED, 0.5) == cost_of(avoid, OBSERVED, 0.5)
    for costs in (bounce, tolerate, avoid):
        assert cost_of(costs, SLIDES, 0.05) == cost_of(costs, NO_CONTACT, 0.0) == 0.0


@given(
    strategy=st.sampled_from(["bounce", "tolerate", "avoid", "stop_guarantee"]),
    limit=st.floats(0.1, 1.2),
    slower=st.floats(0.0, 1.0),
    over=st.floats(1e-3, 1.0),
    more=st.floats(1e-3, 1.0),
)
def test_a_contact_above_the_limit_costs_more_than_any_other_plan_and_a_harder_one_never_less(
    strategy, limit, slower, over, more
):
    costs = contact_costs(with_strategy(strategy, limits__impact_speed=limit))
    longest = LONGEST_PLAN
    for kind in (OBSERVED, INFERRED):
        slow = IMPACT_SPEED + slower * (limit - IMPACT_SPEED)
        assert 0.0 <= cost_of(costs, kind, slow) <= cost_of(costs, kind, limit) < 5.0
        assert cost_of(costs, kind, limit + over) > 10.0 * longest
        # by far more than a way round one and a contact less on it are worth
        assert cost_of(costs, kind, limit + over + more) - cost_of(costs, kind, limit + over) > 500.0 * more
    assert cost_of(costs, SLIDES, limit + over) == 0.0


def test_by_hand_what_an_interval_within_the_margin_costs():
    costs, problem = contact_costs(with_strategy("bounce")), ROOM
    for clearance in (0.0, 0.005, 0.02, 0.05):
        place = Motion(HALF - clearance, 0.0, 1.0, 0.0, 0.0, 0)
        within = max(0.0, 1.0 - clearance / costs.margin)
        expected = CONTROL_INTERVAL * costs.near * costs.margin**2 * within**2
        assert margin_cost(problem.clearance, problem.constants.grid, costs, place) == pytest.approx(expected, abs=1e-6)


STOPPING = robot_model(with_strategy("stop_guarantee"))
BRAKE = BRAKING_SHARE * STOPPING.wheels.max_acceleration
BRAKING = SPEED**2 / (2.0 * BRAKE)
"""Distance in which the robot brakes from full speed [m]."""
FACE = faces_field((np.pi, 1.0))
"""Met at x = 1."""
FLOOR = open_field()


def stops(problem, position, velocity) -> bool:
    return bool(admits_stop(problem, motion_in(problem, (*position, *velocity))))


def seen_up_to(x: float):
    nodes = FLOOR.origin[0] + FLOOR.spacing * np.arange(len(FLOOR.clearance))
    return problem_over(FLOOR, free=np.tile((nodes <= x)[:, None], (1, len(nodes))))


BEHIND_WALL, SEEN = problem_over(FACE, (0.5, 0.5)), seen_up_to(1.0)


def test_at_full_speed_it_needs_its_braking_distance():
    for problem in [BEHIND_WALL, SEEN]:
        assert stops(problem, (1.0 - BRAKING - 0.05, 0.0), (SPEED, 0.0)), problem
        assert stops(problem, (0.99, 0.0), (-SPEED, 0.0)), problem
        assert stops(problem, (0.95, 0.0), (0.0, SPEED)), problem
        # swerving by up to 1.2 rad first does not help head-on so near
        assert not stops(problem, (1.0 - 0.4 * BRAKING, 0.0), (SPEED, 0.0)), problem


def test_swerving_saves_where_braking_straight_does_not():
    block = walls((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0))
    problem = problem_over(walls_field(block), (-1.0, -1.0))
    touches = -np.sqrt(RADIUS**2 - 0.06**2)
    assert touches < -0.35 + BRAKING
    assert stops(problem, (-0.35, -0.06), (SPEED, 0.0))
    assert stops(problem, (-0.06, -0.35), (0.0, SPEED))
    # before the middle of its face it is too wide to pass
    assert not stops(problem, (-0.35, 0.5), (SPEED, 0.0))


@given(
    x=st.floats(0.2, 0.95), speed=st.floats(0.1, SPEED), bearing=st.floats(-np.pi, np.pi), slower=st.floats(0.0, 1.0)
)
def test_it_mirrors_and_braking_straight_in_time_is_enough(x, speed, bearing, slower):
    velocity = speed * unit(bearing)
    answer = stops(BEHIND_WALL, (x, 0.0), velocity)
    assert stops(BEHIND_WALL, (x, 0.0), velocity * (1.0, -1.0)) == answer
    # a step of braking more or less
    if x + speed * max(np.cos(bearing), 0.0) * (0.5 * speed / BRAKE + STEP) < 1.0:
        assert answer


def test_without_an_answer_the_plan_costs_too_much_to_win():
    problems = [of_strategy(BEHIND_WALL, "stop_guarantee", stop_test=test) for test in (True, False)]
    begin, onward = (1.0 - 0.4 * BRAKING, 0.0, SPEED, 0.0), np.tile((SPEED, 0.0), (10, 1))
    asked, unasked = (rolled(problem, begin, onward) for problem in problems)
    assert asked.cost == pytest.approx(unasked.cost + UNSTOPPABLE)
    # the state that is tested is the one at the end of the second control interval
    np.testing.assert_array_equal(asked.costs[:2], unasked.costs[:2])
    assert asked.costs[2] == pytest.approx(unasked.costs[2] + UNSTOPPABLE)
    standing = [rolled(problem, (0.0,) * 4, np.zeros((10, 2))).cost for problem in problems]
    assert standing[0] == standing[1]
