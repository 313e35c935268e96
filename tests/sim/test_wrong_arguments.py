"""Wrong arguments to the library: errors that name the argument, the value and what was expected."""

import numpy as np
import pytest

from collplan_core import Planner, Settings, State, load_world, plan_once, register, simulate_scan, timed_path
from collplan_core.planners import PLANNERS, planner_for
from collplan_core.strategies import NAMES
from omnipuck_sim import run_trial

SETTINGS = Settings()
FLOOR = load_world("floor")
STATE = State.at_rest(FLOOR.start)
SCAN = simulate_scan(FLOOR, STATE, SETTINGS.lidar)
LINE = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
TIMES = np.arange(3.0)
NAN = float("nan")


def half_nan():
    return np.where(LINE == 2.0, NAN, LINE)


def plan(memory, local_map, state, goal, settings, deadline=None):
    return timed_path(state.stamp, state.stamp + TIMES, LINE, LINE), memory


def once(returned):
    """Calls plan_once with a planner that returns this."""
    register("mine", Planner(lambda *given: returned, 0.1))
    return plan_once(SCAN, STATE, FLOOR.goal, SETTINGS.with_values({"planner.strategy": "mine"}))


WRONG = [
    (lambda: timed_path(0.0, [0.0, 1.0, 1.0], LINE, LINE), r"times\[2\]: got time 1.0 after 1.0, expected a later"),
    (lambda: timed_path(0.0, [0.0, 1.0, NAN], LINE, LINE), r"times\[2\]: got nan, expected finite times"),
    (lambda: timed_path(0.0, TIMES, LINE[:2], LINE), r"positions: got \[\[.*expected finite x, y for each of 3 times"),
    (lambda: timed_path(0.0, TIMES, LINE, half_nan()), r"velocities\[2\]: got \[nan, 0.0\], expected finite"),
    (lambda: register("mine", plan), r"planner: got <function plan.*expected Planner, as in Planner\(plan"),
    (lambda: Planner(0.1, plan), "plan: got 0.1 .*expected a function of memory, local_map"),
    (lambda: Planner(plan, 0.0), "map_period: got 0.0, expected a time above 0"),
    (lambda: once(None), "planner mine: returned None, expected a Plan and the next memory"),
    (lambda: once((timed_path(7.0, TIMES, LINE, LINE), None)), r"planner mine: times\[0\]: got 0.0, .*stamp, 7.0"),
    (lambda: plan_once(SCAN, FLOOR.start, FLOOR.goal, SETTINGS), r"state: got array.*expected State"),
    (lambda: plan_once(SCAN, STATE, [1.0, NAN], SETTINGS), r"goal\[1\]: got nan, expected x, y"),
    (lambda: State.at_rest([1.0, 2.0, 3.0]), r"position: got \[1.0, 2.0, 3.0\], expected x, y"),
    (lambda: run_trial("flor", SETTINGS, 0), "world 'flor': unknown.*did you mean floor"),
    (lambda: run_trial("floor", {"planner.strategy": "bounce"}, 0), "settings: got {'planner.*expected Settings"),
]


@pytest.fixture
def own_names(monkeypatch):
    """Planners and their names as they were, afterwards."""
    monkeypatch.setattr("collplan_core.planners.PLANNERS", dict(PLANNERS))
    names = list(NAMES)
    yield
    NAMES[:] = names


def test_a_wrong_argument_is_named_with_its_value_and_what_was_expected(own_names):
    for call, words in WRONG:
        with pytest.raises((TypeError, ValueError), match=words):
            call()


def test_a_list_is_as_good_as_an_array_and_a_name_as_a_world(own_names, tmp_path):
    made = timed_path(0, [0, 1, 2], LINE.tolist(), LINE.tolist())
    assert made.positions.dtype == made.times.dtype == float
    register("mine", Planner(plan, 1))
    assert planner_for("mine").plan(5, None, STATE, None, None)[1] == 5
    quick = SETTINGS.with_values({"trial.timeout": 1.0, "planner.strategy": "bounce", "time_to_goal.proposals": 20})
    result = run_trial("floor", quick, 0, goal=FLOOR.goal.tolist(), journal=str(tmp_path / "trial.journal"))
    np.testing.assert_array_equal(result.trajectory, run_trial(FLOOR, quick, 0).trajectory)
