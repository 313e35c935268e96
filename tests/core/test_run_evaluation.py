"""When a run has ended, how long its path was, which impacts its plans foresaw, and which machine was too slow."""

import numpy as np
import pytest

from collplan_core.command import FREE_SPACE, HAND, STOPPED
from collplan_core.evaluation.run_end import (
    STUCK,
    TIMEOUT,
    RunMonitor,
    Timing,
    drive_noise_hint,
    machine_verdict,
    measured_path_length,
    pace_words,
    path_length,
)
from collplan_core.parameters import Settings, Trial

LIMITS = Trial(timeout=30.0, stuck_time=5.0, stuck_distance=0.05)
GIVEN = 100.0


def monitor(executing: float | None = GIVEN) -> RunMonitor:
    made = RunMonitor(LIMITS, GIVEN)
    if executing is not None:
        made.executing(executing)
    return made


def test_worked_by_hand():
    run = monitor()
    assert [run.outcome(GIVEN + t, np.array([0.01 * t, 0.0])) for t in (0.0, 4.9, 5.0)] == [None, None, None]
    assert [run.outcome(GIVEN + t, np.array([0.06, 0.01])) for t in (5.1, 9.9)] == [None, None]
    assert (run.reason, run.outcome(110.0, np.array([0.06, 0.01]))) == ("", STUCK)
    assert "0.05 m" in run.reason
    assert monitor().outcome(130.0, np.zeros(2)) == TIMEOUT
    # a wait for the first plan delays the end; without a plan it is stuck after the longest run
    run = monitor(GIVEN + 20.0)
    assert [run.outcome(GIVEN + t, np.array([0.01 * t, 0.0])) for t in (0.0, 20.0, 24.9, 31.0)] == [None] * 4
    assert run.outcome(GIVEN + 50.0, np.array([1.0, 0.0])) == TIMEOUT
    run = monitor(None)
    assert [run.outcome(GIVEN + t, np.array([0.01 * t, 0.0])) for t in (0.0, 29.9, 30.0)] == [None, None, STUCK]
    assert "30 s" in run.reason


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


def test_a_polyline_worked_by_hand():
    assert path_length(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]])) == pytest.approx(6.0)
    assert path_length(np.zeros((1, 2))) == 0.0
    assert measured_path_length(np.zeros(1), np.zeros((1, 2))) == 0.0
    # poses that were lost are bridged
    times = 1.7e9 + np.delete(0.01 * np.arange(300), np.arange(100, 115))
    positions = (times - times[0])[:, None] * np.array([0.8, 0.2])
    assert measured_path_length(times, positions) == pytest.approx(path_length(positions), rel=1e-3)


def test_noise_adds_little_where_the_plain_sum_adds_much():
    for seed in range(3):
        times = 0.01 * np.arange(600)
        angle = 0.8 * times
        exact = np.column_stack([np.cos(angle), np.sin(angle)])
        noisy = exact + np.random.default_rng(seed).normal(0.0, 0.002, exact.shape)
        length = path_length(exact)
        assert path_length(noisy) > 1.04 * length, seed
        assert measured_path_length(times, noisy) == pytest.approx(length, rel=0.01), seed


def test_a_machine_is_too_slow_by_its_factor_or_by_a_gap_that_a_command_does_not_outlive():
    table = [
        (Timing(), 1.0, []),
        (Timing(0.97, 0.19), 1.0, []),
        (Timing(0.43, 0.34), 1.0, ["0.43", "0.34"]),
        (Timing(None, 2.04), 1.0, ["2.04"]),
        # slow motion is not the machine's fault; at its pace a command is as old as it looks
        (Timing(0.5, 0.35), 0.5, []),
        (Timing(0.45, 0.1), 0.5, ["0.45"]),
        (Timing(0.61, 0.0), 0.0, []),
        # faster than real time is more than a real robot asks for
        (Timing(1.2, 0.05), 4.0, []),
    ]
    for timing, speed_factor, words in table:
        verdict = machine_verdict(timing, speed_factor, 0.2)
        assert bool(verdict) == bool(words), timing
        assert all(each in verdict for each in words), verdict
    said = [bool(pace_words(factor)) for factor in (None, 1.04, 0.96, 0.85, 4.0)]
    assert said == [False, False, False, True, True]


def test_noise_that_rivals_the_speed_of_a_slow_robot_is_named():
    for speed, noise, named in ((1.2, 1.0, False), (0.05, 1.0, True), (0.05, 0.1, False), (1.2, 10.0, True)):
        hint = drive_noise_hint(Settings().with_values({"robot.max_speed": speed, "simulator.noise": noise}))
        assert ("simulator.noise" in hint and f"{speed:g} m/s" in hint) == named
