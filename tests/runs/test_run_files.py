"""The files that a run leaves in its folder, from a log made by hand; the folder itself, and the link to the newest."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from collplan_core.parameters import Settings
from collplan_ros.bringup.ending import StartError
from collplan_ros.bringup.main import make_pictures, write_results
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.run.record import record_of
from collplan_ros.run.recorded_run import SUMMARY, RecordedRun
from collplan_ros.run.result_files import COLUMNS, PICTURE, TRAJECTORY, summarize, write_trajectory
from collplan_ros.run.run_log import PoseRow, RunLog, SentCommand, SentName, SentPoint
from collplan_ros.run.whole_file import FolderLock
from made_runs import EPOCH, GOAL, RADIUS, SPEED, WINDOW, bouncing_run, detected_only, room


def run_in(folder: RunFolder, log: RunLog) -> RecordedRun:
    log.simulated = True
    return RecordedRun(folder.path, Settings(), room(), log, 0, "/", has_results=False, is_whole=True, has_ended=False)


PREPARED = Preparation(Options(), Settings(), room(), GOAL, {})


def test_all_files_are_written(tmp_path):
    folder = RunFolder(tmp_path / "runs", Settings())
    folder.become_latest()
    log = bouncing_run()
    write_results(run_in(folder, log), PREPARED, "reached", "a reason")
    assert not any(PICTURE in why for why in make_pictures(run_in(folder, log), PREPARED))
    latest = tmp_path / "runs" / "latest"
    summary = json.loads((latest / "summary.json").read_text())
    assert (summary["simulated"], summary["reason"]) == (True, "a reason")
    assert summary["assumed"]["robot.radius"] == RADIUS
    assert (summary["real_time_factor"], summary["longest_gap_s"]) == (pytest.approx(1.0), pytest.approx(0.05))
    assert summary["machine"] == ""
    (impact,) = csv.DictReader((latest / "impacts.csv").open())
    assert (impact["foreseen"], impact["deliberate"]) == ("true", "true")
    vectors = [[float(impact[f"{name}_v{axis}"]) for axis in "xy"] for name in ("before", "after")]
    np.testing.assert_allclose(vectors, [[SPEED, 0.0], [-0.5 * SPEED, 0.0]], atol=1e-5)
    last = list(csv.DictReader((latest / "trajectory.csv").open()))[-1]
    assert float(last["t"]) == pytest.approx(summary["arrival_time_s"], abs=1e-6)
    with Image.open(latest / "trajectory.png") as image:
        darkest, lightest = image.convert("L").getextrema()
    assert darkest < lightest


def test_what_fails_costs_only_what_comes_after_it(tmp_path, monkeypatch):
    def fail(*_):
        raise ValueError("no font")

    monkeypatch.setattr("collplan_ros.bringup.main.draw_trajectory", fail)
    folder = RunFolder(tmp_path, Settings())
    write_results(run_in(folder, bouncing_run()), PREPARED, "reached")
    assert "no font" in make_pictures(run_in(folder, bouncing_run()), PREPARED)[0]
    left = ["impacts.csv", "log", "parameters.yaml", "summary.json", "trajectory.csv"]
    assert sorted(entry.name for entry in folder.path.iterdir()) == left
    monkeypatch.setattr("collplan_ros.run.recorded_run.record_of", fail)
    folder = RunFolder(tmp_path, Settings())
    with pytest.raises(ValueError, match="font"):
        write_results(run_in(folder, bouncing_run()), PREPARED, "reached")
    assert len((folder.path / TRAJECTORY).read_text().splitlines()) == 201


def test_a_run_of_which_nothing_is_known_still_has_its_files(tmp_path):
    folder = RunFolder(tmp_path, Settings())
    summary = write_results(run_in(folder, RunLog()), PREPARED, "graph_lost")
    assert summary["reached"] is False
    assert summary["plan_time_ms"] == {"p50": None, "p99": None, "n": 0}
    assert json.loads((folder.path / SUMMARY).read_text())["impacts"] == 0


def test_the_summary_of_a_run_worked_by_hand_with_and_without_its_truth():
    log = bouncing_run()
    summary = summarize(log, record_of(log, WINDOW), "reached", GOAL, Settings())
    assert summary["reached"] is True
    assert summary["arrival_time_s"] == pytest.approx(1.99 - 0.15, abs=1e-6)
    length = SPEED * 0.85 + 0.5 * SPEED * 0.99
    assert summary["path_length_m"] == pytest.approx(length, abs=1e-6)
    assert summary["path_length_source"] == "ground_truth"
    counts = "impacts", "impacts_foreseen", "impacts_deliberate"
    assert [summary[count] for count in counts] == [1, 1, 1]
    assert summary["rebound_direction_error_deg"] == pytest.approx(np.degrees(np.arctan2(0.8, 0.6)))
    assert summary["plan_time_ms"] == {"p50": pytest.approx(91.0), "p99": pytest.approx(181.0, rel=0.02), "n": 10}
    assert summary["control_period_ms"]["p50"] == pytest.approx(50.0)
    assert summary["candidates"] == {"mean": 10.0, "before_pruning_mean": 30.0}
    assert summary["maneuvers"] == {"free_space": summary["control_period_ms"]["n"] + 1}
    assert summary["impacts_with_movers"] == 0
    log.impacts += [replace(log.impacts[0], with_mover=True)] * 2
    summary = summarize(log, record_of(log, WINDOW), "reached", GOAL, Settings())
    assert [summary[count] for count in ("impacts", "impacts_with_movers")] == [3, 2]
    log = detected_only(log)
    summary = summarize(log, record_of(log, WINDOW), "timeout", GOAL, Settings())
    assert [summary[count] for count in counts] == [1, 1, 1]
    assert summary["arrival_time_s"] is None
    assert "5 Hz" in summary["path_length_source"]
    assert summary["path_length_m"] == pytest.approx(length, rel=0.05)


def test_the_trajectory_worked_by_hand(tmp_path):
    log = RunLog(
        poses=[PoseRow(EPOCH, *[0.0] * 5, 77.0), PoseRow(EPOCH + 0.5, 0.4, 1.0, 0.1, 0.8, 2.0, 77.5)],
        sent_commands=[SentCommand(77.1, 0.3, -0.1, 0.2), SentCommand(77.6, 9.0, 9.0, 9.0)],
        sent_maneuvers=[SentName(77.101, "free_space")],
        sent_references=[SentPoint(77.101, 0.5, 1.0)],
    )
    write_trajectory(tmp_path / "trajectory.csv", log)
    first, second = csv.DictReader((tmp_path / "trajectory.csv").open())
    assert tuple(first) == COLUMNS
    assert (first["cmd_vx"], first["ref_x"], first["maneuver"]) == ("nan", "nan", "stopped")
    assert (float(first["t"]), second["maneuver"]) == (pytest.approx(-0.1, abs=1e-6), "free_space")
    row = [0.4, 0.4, 1.0, 0.1, 0.8, 2.0, 0.3, -0.1, 0.2, 0.5, 1.0]
    assert [float(second[key]) for key in COLUMNS[:-1]] == pytest.approx(row, abs=1e-6)


def test_what_was_sent_between_two_poses_is_between_their_stamps_at_any_pace_of_a_simulation():
    for pace in (0.1, 1.0, 20.0):
        poses = [PoseRow(100.0 + 0.1 * k, 0.0, 0.0, 0.0, 0.0, 0.0, 5.0 + 0.1 * k / pace) for k in range(3)]
        log = RunLog(poses=poses, sent_commands=[SentCommand(5.0 + 0.14 / pace, 1.0, 0.0, 0.0)], pace=pace)
        log.reached_sent = 5.0 + 0.16 / pace
        assert record_of(log, WINDOW).commands[0, 0] == pytest.approx(100.14)
        assert (log.time_zero, log.arrival) == pytest.approx((100.14, 100.16))


def test_runs_of_the_same_second_have_folders_of_their_own_each_locked_until_its_run_is_over(tmp_path):
    folders = [RunFolder(tmp_path, Settings()) for _ in range(3)]
    for folder in folders:
        folder.become_latest()
    assert (tmp_path / "latest").resolve() == folders[-1].path
    folders[0].discard()
    left = sorted(["latest", folders[1].path.name, folders[2].path.name])
    assert sorted(entry.name for entry in tmp_path.iterdir()) == left
    with pytest.raises(BlockingIOError):
        FolderLock(folders[1].path)
    folders[1].close()
    FolderLock(folders[1].path).close()


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StartError, match=r"file/runs: cannot be written: Not a directory"):
        RunFolder(tmp_path / "file" / "runs", Settings())
    (tmp_path / "latest" / "in_the_way").mkdir(parents=True)
    assert f"no link {tmp_path / 'latest'}" in RunFolder(tmp_path, Settings()).become_latest()
