"""When a run is called timed out or stuck."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from collplan_core.command import FREE_SPACE, HAND, STOPPED
from collplan_core.evaluation.run_end import STUCK, TIMEOUT, RunMonitor
from collplan_core.parameters import Trial

LIMITS = Trial(timeout=30.0, stuck_time=5.0, stuck_distance=0.05)
GIVEN = 100.0
PERIOD = 0.125
"""Between poses [s]; sums of it are exact."""


def monitor(executing: float | None = GIVEN) -> RunMonitor:
    made = RunMonitor(LIMITS, GIVEN)
    if executing is not None:
        made.executing(executing)
    return made


def end_of(run: RunMonitor, positions: np.ndarray) -> tuple[float, str] | None:
    """Time since the goal was given and outcome of the run's end, for positions (n, 2) at every PERIOD since then."""
    for k, position in enumerate(positions):
        outcome = run.outcome(GIVEN + PERIOD * k, position)
        if outcome:
            return PERIOD * k, outcome
    return None


def walk(steps: list[tuple[float, float]]) -> np.ndarray:
    return np.cumsum(np.array(steps), axis=0)


steps = st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)), min_size=1, max_size=400)
waits = st.integers(0, 200).map(lambda k: PERIOD * k)


def test_worked_by_hand():
    run = monitor()
    assert [run.outcome(GIVEN + t, np.array([0.01 * t, 0.0])) for t in (0.0, 4.9, 5.0)] == [None, None, None]
    assert [run.outcome(GIVEN + t, np.array([0.06, 0.01])) for t in (5.1, 9.9)] == [None, None]
    assert (run.reason, run.outcome(110.0, np.array([0.06, 0.01]))) == ("", STUCK)
    assert "0.05 m" in run.reason
    assert monitor().outcome(130.0, np.zeros(2)) == TIMEOUT


def test_a_robot_that_a_person_took_is_not_stuck_before_a_plan_drives_it_again():
    run, here = monitor(), np.zeros(2)
    run.commanded(FREE_SPACE)
    assert run.outcome(GIVEN + 3.0, here) is None
    run.commanded(HAND)
    assert run.outcome(GIVEN + 9.0, here) is None
    run.commanded(STOPPED)
    assert run.outcome(GIVEN + 15.0, here) is None
    run.commanded(FREE_SPACE)
    assert run.outcome(GIVEN + 19.9, here) is None
    assert run.outcome(GIVEN + 20.0, here) == STUCK


@given(steps)
@settings(derandomize=True, deadline=None, max_examples=25)
def test_a_stuck_robot_has_stayed_within_the_distance_for_the_time(changes):
    positions = np.vstack([walk(changes), np.full((100, 2), walk(changes)[-1])])
    time, outcome = end_of(monitor(), positions)
    if outcome == STUCK:
        recent = positions[round((time - LIMITS.stuck_time) / PERIOD) : round(time / PERIOD) + 1]
        assert np.linalg.norm(recent - recent[0], axis=1).max() < LIMITS.stuck_distance


@given(steps, waits)
@settings(derandomize=True, deadline=None, max_examples=25)
def test_a_wait_for_the_first_plan_only_delays_the_end(changes, wait):
    positions = np.vstack([walk(changes), np.full((100, 2), walk(changes)[-1])])
    standing = np.full((round(wait / PERIOD), 2), positions[0])
    prompt = end_of(monitor(), positions)
    late = end_of(monitor(GIVEN + wait), np.vstack([standing, positions]))
    assert late == (pytest.approx(prompt[0] + wait, abs=1e-6), prompt[1])


@given(steps)
@settings(derandomize=True, deadline=None, max_examples=20)
def test_without_a_plan_a_run_is_stuck_after_the_longest_run_wherever_the_robot_is(changes):
    run = monitor(None)
    end = end_of(run, np.resize(walk(changes), (400, 2)))
    assert end == (pytest.approx(LIMITS.timeout), STUCK)
    assert "30 s" in run.reason
