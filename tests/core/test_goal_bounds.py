"""Any finite goal: refused with the reason, or planned for at a bounded cost; the fence for goals and poses."""

import os
import time
import tracemalloc
from functools import cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from collplan_core.command import STOPPED
from collplan_core.deadline import after
from collplan_core.goal import ABORTED, ACCEPTED, EXECUTING, Goal
from collplan_core.loop.controller_loop import ControllerLoop
from collplan_core.loop.planner_loop import PlannerLoop
from collplan_core.parameters import Settings
from collplan_core.time_to_goal_planner.shortest_paths.grid import MOST_ALONG, MOST_CELLS, cells_around
from loop_scenes import HALL, IDENTITY, at, notices, scan_at, see, statuses, straight_plan
from time_to_goal_scenes import open_field

COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") == "0"
LONGEST, LARGEST = (0.1 if COMPILED else np.inf), 100e6
"""Most time of a core [s] and memory [bytes] that a cycle may take."""
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
@pytest.mark.parametrize("strategy", ["harness", "bounce", "avoid"])
@settings(derandomize=True, deadline=None, max_examples=25, print_blob=True)
@given(goal=anything)
@example(goal=(1e9, 0.3))
@example(goal=(1e10, 0.3))
@example(goal=(0.3, -1e308))
@example(goal=(99.0, 0.0))
@example(goal=(70.0, 70.0))
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
    # once more to be timed: tracing slows what it traces, and the first call of all may load compiled code
    loop = planner(strategy)
    see(loop, 1.0)
    loop.take_goal(IDENTITY, np.array(goal), 1.0)
    see(loop, 1.01)
    begun = time.process_time()
    loop.cycle(1.01)
    assert time.process_time() - begun < LONGEST, goal


@settings(derandomize=True, deadline=None, max_examples=60, print_blob=True)
@given(goal=st.tuples(finite.filter(lambda v: abs(v) < 1e150), finite.filter(lambda v: abs(v) < 1e150)))
@example(goal=(1e9, 0.3))
@example(goal=(1e12, 0.0))
def test_the_cells_of_the_shortest_paths_are_bounded_for_any_goal(goal):
    cells, _ = cells_around(open_field(), np.array(goal), np.zeros(2), 0.03)
    rows, columns = cells.blocked.shape
    assert max(rows, columns) <= MOST_ALONG + 3
    assert cells.blocked.size <= MOST_CELLS + 3 * (rows + columns) + 9


def test_a_goal_taken_before_the_first_pose_is_refused_once_it_is_known_where_the_robot_is():
    loop = planner("harness")
    assert statuses(loop.take_goal(IDENTITY, np.array([1e9, 0.3]), 0.9)) == [ACCEPTED]
    see(loop, 1.0)
    decisions = loop.cycle(1.01)
    assert statuses(decisions) == [ABORTED]
    assert "1e+09, 0.3 is 1e+09 m away, expected at most 100 m" in loop.trouble


FENCE = (-0.5, -2.0, 1.0, -2.0, 1.0, 2.0, -0.5, 2.0)
FENCED = Settings().with_values({"planner.strategy": "harness", "limits.fence": FENCE})


def test_a_goal_beyond_the_fence_is_refused_with_the_reason():
    loop = PlannerLoop(FENCED, lambda each: after(0.025))
    see(loop, 1.0)
    assert statuses(loop.take_goal(IDENTITY, np.array([0.9, 0.0]), 1.0)) == [ACCEPTED]
    decisions = loop.take_goal(IDENTITY, np.array([2.0, 0.0]), 1.0)
    assert statuses(decisions) == [ABORTED]
    assert notices(decisions)[0][1] == "goal refused: 2, 0 lies outside of limits.fence"


def test_a_robot_that_leaves_the_fence_loses_its_goal_and_gets_none_until_it_is_back():
    loop = PlannerLoop(FENCED, lambda each: after(0.025))
    see(loop, 1.0, x=0.98)
    loop.take_goal(IDENTITY, np.array([0.5, 0.0]), 1.0)
    see(loop, 1.02, x=0.99)
    assert statuses(loop.cycle(1.02)) == [EXECUTING]
    assert statuses(see(loop, 1.03, x=1.01)) == [ABORTED]
    assert loop.trouble == "goal given up: the robot at 1.01, 0.00 is outside of limits.fence"
    assert statuses(loop.take_goal(IDENTITY, np.array([0.5, 0.0]), 1.03)) == [ABORTED]
    see(loop, 1.04, x=0.99)
    assert not loop.cycle(1.05)
    assert statuses(loop.take_goal(IDENTITY, np.array([0.5, 0.0]), 1.05)) == [ACCEPTED]


@settings(derandomize=True, deadline=None, max_examples=40, print_blob=True)
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
    if -0.5 <= x <= 1.0:
        assert command.maneuver != STOPPED
    else:
        assert command.reason == f"the robot at {x:.2f}, {y:.2f} is outside of limits.fence"
        assert not command.velocity.any()
