"""Smoothing: derivatives against differences, limits, known optima, rebounds."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.parameters import Robot
from collplan_core.reflection import Ring, rebound, rebound_slope
from collplan_core.time_to_goal_planner.full_plan import FullPlan, sample_trajectory
from collplan_core.time_to_goal_planner.initial_plans import extended, padded
from collplan_core.time_to_goal_planner.model import Problem
from collplan_core.time_to_goal_planner.smoothing.backward import backward
from collplan_core.time_to_goal_planner.smoothing.forward import (
    ACCELERATION_SHARE,
    MORE_LAG,
    beyond,
    contact_terms,
    forward,
    stage,
    too_fast,
)
from collplan_core.time_to_goal_planner.smoothing.knots import Gains, Knots, knots_of
from collplan_core.time_to_goal_planner.smoothing.smooth import copied, smooth_knots, smoothed
from collplan_core.velocity_bounds import velocity_bounds
from scenes import rotation, unit
from time_to_goal_scenes import (
    ACCELERATION,
    SETTINGS,
    SPEED,
    faces_field,
    has_arrived,
    joined,
    motion_in,
    open_field,
    pillars_field,
    problem_over,
    rolled,
)

FEW = settings(derandomize=True, deadline=None, max_examples=20, print_blob=True)
STEP = 1e-6
OPEN = problem_over(open_field(), (1.0, 0.0))
WALL = problem_over(faces_field((np.pi, 0.5)), (-1.2, 0.3))
"""Met by the disc's centre at x = 0.5."""
POST = problem_over(joined(pillars_field((0.0, 0.05, 0.1)), faces_field((np.pi / 2, 0.6))), (1.2, 0.0), "avoid")
INTO_WALL = np.vstack([np.tile((1.1, 0.2), (14, 1)), np.tile((-1.1, 0.1), (12, 1))])
angles = st.floats(-np.pi, np.pi)
velocities = st.tuples(st.floats(0.2, SPEED), angles).map(lambda v: v[0] * unit(v[1]))


def slopes(function, place) -> np.ndarray:
    return np.stack([(function(place + d) - function(place - d)) / (2 * STEP) for d in STEP * np.eye(2)], axis=-1)


def assert_derived(term_at, place) -> None:
    """Gradient and Hessian of a term against differences of value and gradient."""
    term = term_at(*place)
    np.testing.assert_allclose((term.gx, term.gy), slopes(lambda p: term_at(*p).value, place), rtol=1e-5, atol=1e-6)
    hessian = slopes(lambda p: np.array(term_at(*p)[1:3]), place)
    np.testing.assert_allclose([[term.hxx, term.hxy], [term.hxy, term.hyy]], hessian, rtol=1e-4, atol=1e-4)


@FEW
@given(v=velocities, bearing=angles, e=st.floats(0.0, 1.0), mu=st.floats(0.0, 0.6), share=st.floats(0.5, 1.0))
def test_derivatives_are_those_of_differences(v, bearing, e, mu, share):
    constants, normal = WALL.constants, unit(bearing)
    ring = Ring(e, mu, 1.0 / 3.0, share)
    slope = np.reshape(rebound_slope(*v, *normal, ring), (2, 2))
    into, along = abs(v @ normal), abs(v @ (-normal[1], normal[0]))
    # away from where it bends: the turn of the rebound, and from sliding to gripping
    if min(into, along, abs(mu * (1.0 + e) * into - along / 3.0)) > 1e-3:
        np.testing.assert_allclose(slope, slopes(lambda v: rebound(v, normal, ring), v), atol=1e-6)
    for limit in (0.1, 0.517, 1.197):
        assert_derived(lambda x, y, limit=limit: beyond(20.0, x, y, limit), v)
        turned_box = velocity_bounds(Robot(max_speed=limit, velocity_shape="box"), bearing)
        if min(abs(abs(v @ axis) - limit) for axis in rotation(bearing).T) > 1e-3:
            assert_derived(lambda x, y, bounds=turned_box: too_fast(20.0, x, y, bounds), v)
    assert_derived(
        lambda x, y: stage(WALL.clearance, constants, 0.05, np.array([x, y, 0.0, 0.0]), 0.0, 0.0).place,
        (0.47, 0.1 * bearing),
    )
    for speed in (0.05, 0.6, 1.3):
        before = speed * np.array([np.cos(0.3), np.sin(0.3)])
        assert_derived(lambda vx, vy: contact_terms(constants, 0.0, -1.0, 0.0, vx, vy)[1], before)


def plan_in(problem: Problem, state, commands) -> FullPlan:
    return extended(problem, motion_in(problem, state), padded(np.array(commands, dtype=float), 160), len(commands))


def knots_in(problem: Problem, plan: FullPlan) -> Knots:
    initial = motion_in(problem, plan.states[0])
    rows, contacts = sample_trajectory(problem, initial, plan.commands[: plan.n], 0.0)
    return knots_of(rows, contacts, 0.0, problem.constants.costs.margin)


def no_gains(knots: Knots) -> Gains:
    return Gains(np.zeros((len(knots.accelerations), 2, 7)), np.zeros((len(knots.ends), 7)))


def passed(problem: Problem, knots: Knots, gains: Gains | None = None, share: float = 0.0) -> tuple[float, Knots]:
    """Cost and knots of a forward pass, without gains that of the accelerations as they are."""
    new = copied(knots)
    return forward(problem, knots, gains or no_gains(knots), share, new), new


@pytest.mark.parametrize("problem", [OPEN, WALL])
def test_the_model_falls_as_fast_as_the_cost_through_contacts_too(problem):
    """By the share taken of what the gains ask for."""
    commands = INTO_WALL if problem is WALL else np.tile((0.5, 0.4), (20, 1))
    best = smooth_knots(problem, knots_in(problem, plan_in(problem, (0.0, 0.0, 0.3, 0.0), commands)))
    beside = np.random.default_rng(0).normal(0.0, 0.05, best.accelerations.shape)
    _, knots = passed(problem, best._replace(accelerations=best.accelerations + beside))
    gains = no_gains(knots)
    slope = backward(problem, knots, 0.1, gains)
    by_share = (passed(problem, knots, gains, STEP)[0] - passed(problem, knots, gains, -STEP)[0]) / (2 * STEP)
    assert by_share == pytest.approx(slope, rel=1e-3)
    assert by_share < 0.0


@pytest.mark.parametrize(
    ("problem", "state", "commands"),
    [
        (OPEN, (-1.0, 0.2, 0.0, 0.5), np.zeros((10, 2))),
        (WALL, (0.0, 0.0, 0.3, 0.0), 0.8 * INTO_WALL),
        (POST, (-1.0, 0.0, 0.0, 0.0), np.tile((0.6, -0.4), (12, 1))),
    ],
)
def test_the_cost_falls_and_limits_hold(problem, state, commands):
    plan = plan_in(problem, state, commands)
    assert has_arrived(problem, plan)
    knots = knots_in(problem, plan)
    before, after = passed(problem, knots)[0], smooth_knots(problem, knots)
    assert passed(problem, after)[0] < before
    assert np.hypot(*after.accelerations.T).max() < 1.02 * ACCELERATION
    assert np.hypot(*after.states[:, 2:].T).max() < 1.03 * SPEED
    places = [motion_in(problem, each).clearance_bound for each in after.states]
    contacts = after.ends[:-1]
    np.testing.assert_allclose(np.array(places)[contacts], 0.0, atol=0.005)
    assert min(places) > -0.005
    if problem is POST:
        assert min(places) > problem.constants.costs.margin - 0.005
    for k in contacts:
        phase = int(np.searchsorted(after.ends, k))
        into = after.states[k - 1, 2:] + after.durations[phase] * after.accelerations[k - 1]
        rebounded = rebound(into, np.array([-1.0, 0.0]), problem.constants.model.ring)
        np.testing.assert_allclose(after.states[k, 2:], rebounded, atol=1e-9)
    assert smoothed(problem, plan).cost < plan.cost


def test_by_hand_straight_across_an_open_floor():
    plan = plan_in(OPEN, (-1.0, 0.0, 0.0, 0.0), np.tile((0.5, 0.5), (20, 1)))
    after, lag = smooth_knots(OPEN, knots_in(OPEN, plan)), SETTINGS.robot.velocity_lag + MORE_LAG
    distance, a, v = 2.0 - OPEN.constants.goal.tolerance, ACCELERATION_SHARE * ACCELERATION, SPEED
    begun = v / a - lag
    lost = begun * v - 0.5 * a * begun**2 + a * lag**2
    assert after.durations @ np.diff(after.ends, prepend=0) == pytest.approx((distance + lost) / v, rel=0.02)
    best = rolled(OPEN, (-1.0, 0.0, 0.0, 0.0), np.tile((SPEED, 0.0), (60, 1)))
    assert best.cost < smoothed(OPEN, plan).cost < 1.02 * best.cost


def test_plans_that_do_not_arrive_or_are_there_soon_are_left_as_they_are():
    away = rolled(OPEN, (-1.0, 0.0, 0.0, 0.0), np.tile((-0.5, 0.0), (20, 1)))
    soon = rolled(OPEN, (0.91, 0.0, 0.5, 0.0), np.tile((SPEED, 0.0), (20, 1)))
    for plan in (away, soon, away._replace(n=0)):
        assert smoothed(OPEN, plan).commands is plan.commands
    assert has_arrived(OPEN, soon)
