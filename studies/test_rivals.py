"""Tests of `make rivals` without the rivals' libraries: an interval of SST, a plan that is followed, the table."""

import math

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_core.plan import timed_path
from collplan_core.state import State
from collplan_core.worlds import load_world
from rivals.__main__ import cells
from rivals.known_problem import known_problem
from rivals.sst import drive, followed

AVOID = Settings().with_values({"planner.strategy": "avoid"})


def test_an_interval_of_sst_is_the_robots_and_takes_forever_into_a_wall():
    world = load_world("u:0")
    problem = known_problem(world, AVOID)
    given, (x, y) = (problem.clearance, problem.source, problem.constants), world.start.tolist()
    end, took = drive(*given, (x, y, 0.0, 0.0), 0.1, 0.0, 1)
    assert took == pytest.approx(0.05)
    assert end[:4] == pytest.approx([x + 0.05 * 0.02, y, 0.1 * (1.0 - math.exp(-0.5)), 0.0], abs=1e-3)
    into_the_wall = [drive(*given, (x, y, -1.2, 0.0), -speed, 0.0, 8)[-1] for speed in (0.0, 1.2)]
    assert into_the_wall == [math.inf, math.inf]


def test_a_plan_made_beforehand_is_followed_from_when_the_run_begins():
    times = np.linspace(0.0, 2.0, 81)
    found = timed_path(0.0, times, np.column_stack([times, 0.0 * times]), np.tile([1.0, 0.0], (81, 1)))
    planner, memory = followed(found).plan, None
    for stamp, x, samples in [(7.0, 0.0, 81), (7.5, 0.5, 61), (9.5, 2.0, 2)]:
        plan, memory = planner(memory, None, State(stamp, np.zeros(2), np.zeros(2), 0.0), np.zeros(2), AVOID)
        assert (plan.stamp, plan.times[0], len(plan.times)) == (stamp, stamp, samples)
        assert plan.positions[0] == pytest.approx([x, 0.0])


def test_times_are_of_the_runs_that_arrived():
    arrived = {"outcome": "reached", "time": 3.0, "contacts": 2, "planning_ms": [1.0, 3.0], "planned": 2.5}
    lost = {"outcome": "no plan", "time": None, "contacts": 0, "planning_ms": [2.0]}
    found = cells([{"world": "u:1", **arrived}, {"world": "u:2", **lost}], {"u:1": 2.0, "u:2": 2.0})
    assert found == ["1 of 2", "1.500 [1.500, 1.500]", "1.250 [1.250, 1.250]", "1.0", "2.0", "3.0"]
