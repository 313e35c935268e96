"""Whether the robot could still brake within what it has seen."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.time_to_goal_planner.model import STEP, robot_model
from collplan_core.time_to_goal_planner.stopping import BRAKING_SHARE, UNSTOPPABLE, admits_stop
from collplan_core.velocity_law import velocity_after
from scenes import unit
from time_to_goal_scenes import (
    RADIUS,
    faces_field,
    motion_in,
    of_strategy,
    open_field,
    problem_over,
    rolled,
    walls,
    walls_field,
    with_strategy,
)

QUICK = settings(derandomize=True, deadline=None, max_examples=30, print_blob=True)
MODEL = robot_model(with_strategy("stop_guarantee"))
SPEED, BRAKE = MODEL.max_speed, BRAKING_SHARE * MODEL.wheels.max_acceleration
BRAKING = SPEED**2 / (2.0 * BRAKE)
"""Distance in which the robot brakes from full speed [m]."""
WALL = faces_field((np.pi, 1.0))
"""Met at x = 1."""
FLOOR = open_field()


def stops(problem, position, velocity) -> bool:
    return bool(admits_stop(problem, motion_in(problem, (*position, *velocity))))


def seen_up_to(x: float):
    """An open floor of which x and less was seen."""
    nodes = FLOOR.origin[0] + FLOOR.spacing * np.arange(len(FLOOR.clearance))
    return problem_over(FLOOR, free=np.tile((nodes <= x)[:, None], (1, len(nodes))))


BEHIND_WALL, SEEN = problem_over(WALL, (0.5, 0.5)), seen_up_to(1.0)


@QUICK
@given(x=st.floats(-1.5, 1.5), y=st.floats(-1.5, 1.5))
def test_at_rest_it_stops_where_it_stands_if_that_was_seen(x, y):
    if abs(x - 1.0) > FLOOR.spacing:
        assert stops(BEHIND_WALL, (x, y), (0.0, 0.0)) == (x < 1.0)
        assert stops(SEEN, (x, y), (0.0, 0.0)) == (x < 1.0)


def test_at_full_speed_it_needs_its_braking_distance():
    for problem in [BEHIND_WALL, SEEN]:
        assert stops(problem, (1.0 - BRAKING - 0.05, 0.0), (SPEED, 0.0)), problem
        assert stops(problem, (0.99, 0.0), (-SPEED, 0.0)), problem
        assert stops(problem, (0.95, 0.0), (0.0, SPEED)), problem
        # swerving by up to 1.2 rad first does not help head-on so near
        assert not stops(problem, (1.0 - 0.4 * BRAKING, 0.0), (SPEED, 0.0)), problem


def test_swerving_saves_where_braking_straight_does_not():
    """A block whose lower left corner is at (0, 0), straight ahead."""
    block = walls((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0))
    problem = problem_over(walls_field(block), (-1.0, -1.0))
    touches = -np.sqrt(RADIUS**2 - 0.06**2)
    assert touches < -0.35 + BRAKING
    assert stops(problem, (-0.35, -0.06), (SPEED, 0.0))
    assert stops(problem, (-0.06, -0.35), (0.0, SPEED))
    # before the middle of its face it is too wide to pass
    assert not stops(problem, (-0.35, 0.5), (SPEED, 0.0))


@QUICK
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


def test_braking_counts_on_less_than_the_wheels_make():
    velocity, distance = SPEED, 0.0
    while velocity > 0.0:
        slower, _ = velocity_after(MODEL.wheels, velocity, 0.0, -SPEED, 0.0, STEP)
        velocity, distance = slower, distance + 0.5 * (velocity + slower) * STEP
    assert distance < BRAKING
