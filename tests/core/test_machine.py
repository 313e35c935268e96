"""Which machine is called too slow for a real robot."""

import pytest

from collplan_core.evaluation.machine import Timing, machine_verdict, pace_words

AGE = 0.2


@pytest.mark.parametrize(
    ("timing", "speed_factor", "words"),
    [
        (Timing(), 1.0, []),
        (Timing(0.97, 0.19), 1.0, []),
        (Timing(0.43, 0.34, "planner_node"), 1.0, ["at 0.43 of real time", "longest wait 0.34 s for planner_node"]),
        (Timing(0.9, 0.05), 1.0, ["at 0.90 of real time"]),
        (Timing(None, 2.04), 1.0, ["between two commands 2.04 s"]),
        # slow motion is not the machine's fault; at its pace a command is as old as it looks
        (Timing(0.5, 0.35), 0.5, []),
        (Timing(0.45, 0.1), 0.5, ["at 0.45"]),
        # faster than real time is more than a real robot asks for
        (Timing(1.2, 0.05), 4.0, []),
        (Timing(0.8, 0.05), 0.0, ["at 0.80"]),
    ],
)
def test_a_machine_is_too_slow_by_its_factor_or_by_a_gap_that_a_command_does_not_outlive(timing, speed_factor, words):
    verdict = machine_verdict(timing, speed_factor, AGE)
    assert bool(verdict) == bool(words)
    assert all(each in verdict for each in words)


@pytest.mark.parametrize(
    ("factor", "words"), [(None, ""), (1.04, ""), (0.96, ""), (0.85, "0.85x real time"), (4.0, "4.00x real time")]
)
def test_a_pace_is_said_where_it_is_not_that_of_real_time(factor, words):
    assert pace_words(factor) == words
