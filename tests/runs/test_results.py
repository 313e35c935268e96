"""The files that a run leaves in its folder, from a log made by hand."""

import csv
import json

import numpy as np
import pytest

from collplan_core.parameters import Settings
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.preparation import Preparation
from collplan_ros.bringup.results import draw_pictures, write_results
from collplan_ros.bringup.robots import ROBOTS
from collplan_ros.bringup.run_folder import RunFolder
from collplan_ros.runs.run_log import RunLog
from made_runs import HIT_AT, RADIUS, SPEED, bouncing_run, room


def prepared() -> Preparation:
    return Preparation(ROBOTS["sim"], "local", Settings(), room(), np.array([0.0, 0.1]), {})


def test_all_files_are_written(tmp_path):
    folder = RunFolder(tmp_path / "runs")
    folder.become_latest()
    log = bouncing_run()
    log.longest_wait = 0.34, "planner_node"
    results = write_results(folder, log, prepared(), "reached", Options(), "for a reason")
    assert draw_pictures(folder, results, prepared()) == ""
    latest = tmp_path / "runs" / "latest"
    summary = json.loads((latest / "summary.json").read_text())
    assert summary["simulated"] is True
    assert summary["assumed"]["robot.radius"] == RADIUS
    assert summary["reason"] == "for a reason"
    assert (summary["real_time_factor"], summary["longest_gap_s"]) == (pytest.approx(1.0), 0.34)
    assert "too slow for a real robot" in summary["machine"]
    impacts = list(csv.DictReader((latest / "impacts.csv").open()))
    assert [(row["foreseen"], row["deliberate"]) for row in impacts] == [("true", "true")]
    assert float(impacts[0]["t"]) == pytest.approx(HIT_AT - 0.153, abs=1e-5)
    vectors = [[float(impacts[0][f"{name}_v{axis}"]) for axis in "xy"] for name in ("before", "after")]
    np.testing.assert_allclose(vectors, [[SPEED, 0.0], [-0.5 * SPEED, 0.0]], atol=1e-5)
    assert float(impacts[0]["direction_error"]) == pytest.approx(np.arctan2(0.8, 0.6), abs=1e-5)
    last = list(csv.DictReader((latest / "trajectory.csv").open()))[-1]
    assert float(last["t"]) == pytest.approx(summary["arrival_time_s"], abs=1e-6)
    from PIL import Image

    for name, frames in (("trajectory.png", 1), ("run.gif", 15)):
        with Image.open(latest / name) as image:
            assert getattr(image, "n_frames", 1) >= frames
            assert image.convert("L").getextrema()[0] < image.convert("L").getextrema()[1]


def test_what_a_drawing_library_refuses_costs_no_figures(tmp_path, monkeypatch):
    from collplan_ros.pictures import trajectory_png

    def refuse(*_):
        raise ValueError("no such font")

    monkeypatch.setattr(trajectory_png, "draw_trajectory", refuse)
    folder = RunFolder(tmp_path)
    results = write_results(folder, bouncing_run(), prepared(), "reached", Options())
    assert draw_pictures(folder, results, prepared()) == "pictures not drawn: ValueError: no such font"
    assert sorted(entry.name for entry in folder.path.iterdir()) == [
        "impacts.csv",
        "log",
        "summary.json",
        "trajectory.csv",
    ]


def test_the_trajectory_is_there_although_the_impacts_cannot_be_told(tmp_path, monkeypatch):
    def fail(*_):
        raise ZeroDivisionError

    monkeypatch.setattr("collplan_ros.runs.result_files.impacts_of", fail)
    folder = RunFolder(tmp_path)
    with pytest.raises(ZeroDivisionError):
        write_results(folder, bouncing_run(), prepared(), "reached", Options())
    assert len(folder.trajectory.read_text().splitlines()) == 201


def test_a_run_of_which_nothing_is_known_still_has_its_files(tmp_path):
    folder = RunFolder(tmp_path)
    results = write_results(folder, RunLog(), prepared(), "graph_lost", Options())
    summary = results.summary
    assert draw_pictures(folder, results, prepared()) == ""
    assert summary["reached"] is False
    assert summary["plan_time_ms"] == {"p50": None, "p99": None, "n": 0}
    assert json.loads(folder.summary.read_text())["impacts"] == 0
