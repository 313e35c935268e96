"""Which machine is called too slow for a real robot."""

from collplan_core.evaluation.machine import Timing, machine_verdict, pace_words


def test_a_machine_is_too_slow_by_its_factor_or_by_a_gap_that_a_command_does_not_outlive():
    table = [
        (Timing(), 1.0, []),
        (Timing(0.97, 0.19), 1.0, []),
        (Timing(0.43, 0.34, "planner_node"), 1.0, ["0.43", "0.34", "planner_node"]),
        (Timing(0.9, 0.05), 1.0, ["0.90"]),
        (Timing(None, 2.04), 1.0, ["2.04"]),
        # slow motion is not the machine's fault; at its pace a command is as old as it looks
        (Timing(0.5, 0.35), 0.5, []),
        (Timing(0.45, 0.1), 0.5, ["0.45"]),
        # faster than real time is more than a real robot asks for
        (Timing(1.2, 0.05), 4.0, []),
        (Timing(0.8, 0.05), 0.0, ["0.80"]),
    ]
    for timing, speed_factor, words in table:
        verdict = machine_verdict(timing, speed_factor, 0.2)
        assert bool(verdict) == bool(words), timing
        assert all(each in verdict for each in words), verdict
    said = [bool(pace_words(factor)) for factor in (None, 1.04, 0.96, 0.85, 4.0)]
    assert said == [False, False, False, True, True]
    assert "0.85" in pace_words(0.85)
