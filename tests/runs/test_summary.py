"""The figures of a run, from a log made by hand."""

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_ros.runs.impact_log import impacts_of
from collplan_ros.runs.run_log import DetectedImpactRecord
from collplan_ros.runs.summary import summarize
from made_runs import EPOCH, HIT_AT, SPEED, WALL, WINDOW, bouncing_run, room


def test_the_summary_of_a_run_worked_by_hand():
    log = bouncing_run()
    summary = summarize(log, impacts_of(log, room(), WINDOW), "reached", np.array([0.0, 0.1]), Settings())
    assert summary["reached"] is True
    assert summary["arrival_time_s"] == pytest.approx(1.99 - 0.15, abs=1e-6)
    assert summary["path_length_m"] == pytest.approx(SPEED * 0.85 + 0.5 * SPEED * 0.99, abs=1e-6)
    assert summary["path_length_source"] == "ground_truth"
    assert (summary["impacts"], summary["impacts_foreseen"], summary["impacts_deliberate"]) == (1, 1, 1)
    assert summary["rebound_direction_error_deg"] == pytest.approx(np.degrees(np.arctan2(0.8, 0.6)))
    assert summary["plan_time_ms"] == {"p50": pytest.approx(91.0), "p99": pytest.approx(181.0, rel=0.02), "n": 10}
    assert summary["control_period_ms"]["p50"] == pytest.approx(50.0)
    assert summary["candidates"] == {"mean": 10.0, "before_pruning_mean": 30.0}
    assert summary["maneuvers"] == {"free_space": summary["control_period_ms"]["n"] + 1}


def test_without_a_truth_the_poses_and_the_detected_impacts_count():
    log = bouncing_run()
    log.truth, log.detected_impacts = [], [DetectedImpactRecord(EPOCH + HIT_AT - 0.003, WALL, 0.1, -1.0, 0.0)]
    impacts = impacts_of(log, room(), WINDOW)
    assert impacts.after[0] == pytest.approx([-0.5 * SPEED, 0.0])
    assert impacts.before[0] == pytest.approx([SPEED, 0.0])
    summary = summarize(log, impacts, "timeout", np.array([0.0, 0.1]), Settings())
    assert (summary["impacts"], summary["impacts_foreseen"], summary["impacts_deliberate"]) == (1, 1, 1)
    assert summary["arrival_time_s"] is None
    assert "5 Hz" in summary["path_length_source"]
    assert summary["path_length_m"] == pytest.approx(SPEED * 0.85 + 0.5 * SPEED * 0.99, rel=0.05)
