"""Any finite goal: refused with the reason, or planned for at a bounded cost; the fence for goals and poses."""

import tracemalloc
from functools import cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from collplan_core.command import STOPPED
from collplan_core.deadline import after
from collplan_core.fence import is_outside
from collplan_core.goal import ABORTED, ACCEPTED, EXECUTING, Goal
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import ParameterError, Settings
from collplan_core.time_to_goal_planner.shortest_paths.grid import MOST_ALONG, MOST_CELLS, cells_around
from loop_scenes import HALL, IDENTITY, at, notices, scan_at, see, statuses, straight_plan
from time_to_goal_scenes import open_field

LARGEST = 100e6
"""Most memory that a cycle may take [bytes]."""
finite = st.floats(allow_nan=False, allow_infinity=False)
within = st.floats(-100.0, 100.0)
anything = st.one_of(st.tuples(finite, finite), st.tuples(within, within), st.tuples(st.just(0.3), within))


@cache
def setting(strategy: str) -> Settings:
    return Settings().with_values({"planner.strategy": strategy})


def planner(strategy: str) -> PlannerLoop:
    """With the share of a T_map that planner_node gives it, in the time that the process has."""
    return PlannerLoop(setting(strategy), lambda each: after(0.025))


@pytest.mark.timeout(600)  # without its compiler
@settings(max_examples=15)
@given(strategy=st.sampled_from(["harness", "bounce", "avoid"]), goal=anything)
@example(strategy="harness", goal=(1e9, 0.3))
@example(strategy="bounce", goal=(1e10, 0.3))
@example(strategy="bounce", goal=(99.0, 0.0))
@example(strategy="avoid", goal=(70.0, 70.0))
def test_any_finite_goal_is_refused_with_the_reason_or_costs_a_bounded_cycle(strategy, goal):
    loop = planner(strategy)
    see(loop, 1.0)
    decisions = loop.take_goal(IDENTITY, np.array(goal), 1.0)
    if np.hypot(*(np.array(goal) / 2.0)) > setting(strategy).limits.goal_distance / 2.0:
        assert statuses(decisions) == [ABORTED]
        assert "limits.goal_distance" in notices(decisions)[0][1]
        return
    assert statuses(decisions) == [ACCEPTED]
    see(loop, 1.01)
    tracemalloc.start()
    loop.cycle(1.01)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < LARGEST, goal
    cells, _ = cells_around(open_field(), np.array(goal), np.zeros(2), 0.03)
    rows, columns = cells.blocked.shape
    assert max(rows, columns) <= MOST_ALONG + 3
    assert cells.blocked.size <= MOST_CELLS + 3 * (rows + columns) + 9


def test_a_goal_taken_before_the_first_pose_is_refused_once_it_is_known_where_the_robot_is():
    loop = planner("harness")
    assert statuses(loop.take_goal(IDENTITY, np.array([1e9, 0.3]), 0.9)) == [ACCEPTED]
    see(loop, 1.0)
    assert statuses(loop.cycle(1.01)) == [ABORTED]
    assert "1e+09 m" in loop.trouble


FENCE = (-0.5, -2.0, 1.0, -2.0, 1.0, 2.0, -0.5, 2.0)
FENCED = Settings().with_values({"planner.strategy": "harness", "limits.fence": FENCE})


def test_no_goal_is_beyond_the_fence_nor_has_a_robot_one_that_left_it_until_it_is_back():
    loop = PlannerLoop(FENCED, lambda each: after(0.025))
    see(loop, 1.0, x=0.98)
    decisions = loop.take_goal(IDENTITY, np.array([2.0, 0.0]), 1.0)
    assert (statuses(decisions), "limits.fence" in notices(decisions)[0][1]) == ([ABORTED], True)
    loop.take_goal(IDENTITY, np.array([0.5, 0.0]), 1.0)
    see(loop, 1.02, x=0.99)
    assert statuses(loop.cycle(1.02)) == [EXECUTING]
    assert statuses(see(loop, 1.03, x=1.01)) == [ABORTED]
    assert "limits.fence" in loop.trouble
    assert statuses(loop.take_goal(IDENTITY, np.array([0.5, 0.0]), 1.03)) == [ABORTED]
    see(loop, 1.04, x=0.99)
    assert not loop.cycle(1.05)
    assert statuses(loop.take_goal(IDENTITY, np.array([0.5, 0.0]), 1.05)) == [ACCEPTED]


@given(x=st.floats(-0.9, 2.9), y=st.floats(-0.4, 0.4))
def test_the_controller_stands_still_outside_of_the_fence_and_says_so(x, y):
    loop = ControllerLoop(FENCED)
    loop.take_goal(Goal(IDENTITY, 0.5, np.full(2, np.nan), EXECUTING))
    state = at(1.0, x, y)
    loop.take_pose(state, 1.0)
    loop.take_scan(scan_at(state), 1.0)
    assert HALL.bounds[0] < x < HALL.bounds[2]
    assert loop.take_plan(straight_plan(1.0), 1.0) == ""
    command = loop.tick(1.0)
    assert (command.maneuver == STOPPED) == ("limits.fence" in command.reason) == (not -0.5 <= x <= 1.0)


CORNERS = (-1.0, -1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0)
ELBOW = (0.0, 0.0, 2.0, 0.0, 2.0, 2.0, 1.0, 2.0, 1.0, 1.0, 0.0, 1.0)
coordinates = st.floats(-3.0, 3.0)


@given(x=coordinates, y=coordinates, begin=st.integers(0, 3), backwards=st.booleans())
def test_what_is_outside_of_a_square_whichever_way_its_corners_are_given_and_of_a_fence_that_is_not_convex(
    x, y, begin, backwards
):
    corners, place = np.roll(np.reshape(CORNERS, (-1, 2)), begin, axis=0), np.array([x, y])
    fence = tuple(corners[:: -1 if backwards else 1].ravel().tolist())
    assert is_outside(fence, place) == (max(abs(x), abs(y)) > 1.0)
    assert is_outside(ELBOW, place) == (not (0.0 <= x <= 2.0 and 0.0 <= y <= 2.0) or (x < 1.0 and y > 1.0))
    assert not is_outside((), place)


def test_what_is_no_polygon_is_refused_with_the_value_and_what_was_expected():
    table = [
        (0.0,),
        (0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0),
        (0.0, 0.0, 1.0, 0.0, 2.0, 0.0),
        (0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0),
        (0.0, 0.0, 1.0, 0.0, 1.0, 1e9),
    ]
    for fence in table:
        with pytest.raises(ParameterError, match=r"limits\.fence: got .*, expected"):
            Settings().with_values({"limits.fence": fence})
    assert Settings().with_values({"limits.fence": []}).limits.fence == ()
