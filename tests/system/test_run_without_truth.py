"""A run through the whole graph whose folder is written without ground truth, as that of a real robot."""

import csv
import io
from types import SimpleNamespace

import numpy as np
import pytest
from logged_trials import pairs_of

from collplan_core.parameters import Settings
from collplan_core.warm_up import warm_up
from collplan_core.worlds import load_world
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.progress import Progress
from collplan_ros.runs.impact_log import impacts_of
from collplan_ros.runs.record_reading import read_record
from collplan_ros.runs.recorder import Recorder
from collplan_ros.runs.run_log import PoseRow, RunLog

WORLD = "serpentine:0"
RUNS = 5
"""So often it is tried on a machine that stalls."""
STALL = 0.05
"""Poses that come so much later than others, or so far apart, tell of a stall [s]."""


def kept_apart(monkeypatch) -> SimpleNamespace:
    """Keeps the truth out of the record of the next run, and gives it."""
    kept = SimpleNamespace(truth=[])

    def aside(self, message, _):
        state = self._state(message)
        kept.truth.append(PoseRow(state.stamp, *state.position.tolist(), state.yaw, *state.velocity.tolist()))

    monkeypatch.setattr(Recorder, "_take_truth", aside)
    return kept


def has_stalled(log: RunLog) -> bool:
    """Whether poses of a run were late: the detection of impacts is then not what is asked about."""
    stamps, sent = np.array([(pose.stamp, pose.sent) for pose in log.poses]).T
    return bool(np.diff(stamps).max() > STALL or np.ptp(sent - stamps) > STALL)


@pytest.mark.soak
def test_impacts_of_a_run_without_truth_are_told_as_they_were(tmp_path, monkeypatch):
    warm_up()
    kept, window = kept_apart(monkeypatch), Settings().mocap.velocity_window
    for k in range(RUNS):
        kept.truth.clear()
        said = io.StringIO()
        result = run(Options(world=WORLD, strategy="bounce", out=tmp_path / f"{k}", pictures=False), Progress(said))
        log = read_record(result.folder / "record.jsonl").log
        if not has_stalled(log):
            break
    assert result.outcome == "reached", said.getvalue()
    assert result.summary["path_length_source"] != "ground_truth"
    found = impacts_of(log, load_world(WORLD), window)
    log.truth[:] = [row for row in kept.truth if row.stamp <= log.poses[-1].stamp]
    true = impacts_of(log, load_world(WORLD), window)
    rows = list(csv.DictReader((result.folder / "impacts.csv").open()))
    assert [float(row["t"]) for row in rows] == [float(f"{t - log.begin:.6f}") for t in found.times]
    assert [row["deliberate"] for row in rows] == [str(bool(told)).lower() for told in found.deliberate]
    assert result.summary["impacts_deliberate"] == found.deliberate.sum()
    pairs = pairs_of(found.times, true.times, 0.08)
    assert len(pairs) == len(found) >= 1, (found.times, true.times)
    late = [abs(found.times[i] - true.times[j]) for i, j in pairs]
    off = [
        [np.hypot(*(a[i] - b[j])) for a, b in zip((found.before, found.after), (true.before, true.after), strict=True)]
        for i, j in pairs
    ]
    assert np.median(late) <= 0.03, late
    assert np.median(off) <= 0.1, off
