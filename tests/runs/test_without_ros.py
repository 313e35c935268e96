"""Run folders are read, compared, fitted, drawn and replayed where ROS cannot be imported."""

import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

from collplan_core.parameters import Settings
from collplan_core.worlds import load_world
from omnipuck_sim.trial import run_trial
from played_folders import drawn_folder, played_folder, recording_in

NO_ROS = """
import sys
missing = ("rclpy", "action_msgs", "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs",
           "rcl_interfaces", "sensor_msgs", "std_msgs", "std_srvs", "visualization_msgs")
sys.modules.update(dict.fromkeys(missing))
"""
"""None in sys.modules makes an import fail."""
COMPARE = """
from collplan_ros.pictures.compare_runs import main
sys.exit(main(sys.argv[1:]))
"""
PAGE = """
from pathlib import Path
from collplan_ros.view.player import write_run_page
write_run_page(Path(sys.argv[1]))
"""
FIT = """
from collplan_ros.runs.fit_robot import main
sys.exit(main(sys.argv[1:]))
"""
REPLAY = """
from collplan_ros.replay.main import main
sys.exit(main(sys.argv[1:]))
"""
DRAW = """
from pathlib import Path
import numpy as np
from collplan_ros.pictures.trajectory_png import draw_trajectory
from collplan_ros.runs.impact_log import impacts_of
from collplan_ros.runs.recorded_run import read_run
from collplan_ros.runs.run_log import PoseRow, RunLog
run = read_run(Path(sys.argv[1]))
rows = np.column_stack([run.path.times, run.path.points])
log = RunLog(poses=[PoseRow(t, x, y, 0.0, 0.0, 0.0) for t, x, y in rows.tolist()])
impacts = impacts_of(log, run.world, run.settings.mocap.velocity_window)
draw_trajectory(Path(sys.argv[2]), log, impacts, run.world, rows[-1, 1:], run.settings, "a run")
"""


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    parent = tmp_path_factory.mktemp("runs")
    return drawn_folder(parent, "slow", 0.4, strategy="avoid"), drawn_folder(parent, "fast", 0.3)


def run_without_ros(program: str, *arguments: Path | str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-c", NO_ROS + program, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=100.0)


def test_ros_is_really_missing():
    done = run_without_ros("import collplan_ros.runs.recorder")
    assert done.returncode != 0
    assert "ModuleNotFoundError" in done.stderr


def test_runs_are_compared(folders, tmp_path):
    out = tmp_path / "beside.gif"
    done = run_without_ros(COMPARE, *folders, "--out", out)
    assert done.returncode == 0, done.stderr
    with Image.open(out) as image:
        assert image.n_frames > 2


def test_a_run_folder_is_read_and_its_trajectory_drawn(folders, tmp_path):
    out = tmp_path / "trajectory.png"
    done = run_without_ros(DRAW, folders[0], out)
    assert done.returncode == 0, done.stderr
    with Image.open(out) as image:
        assert min(image.size) > 300
        assert len(image.convert("RGB").getcolors(1 << 20)) > 50


def test_a_robot_is_asked_for(folders, tmp_path):
    done = run_without_ros(FIT, *folders, "--out", tmp_path / "robot.yaml")
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("fit_robot: ")


def test_a_trial_is_replayed(tmp_path):
    journal = tmp_path / "trial.jsonl"
    settings = Settings().with_values({"planner.strategy": "harness", "trial.timeout": 1.0})
    run_trial(load_world("corridor"), settings, 1, journal=journal)
    done = run_without_ros(REPLAY, journal)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("bit-equal") == 2


def test_a_run_becomes_a_page(tmp_path):
    folder = played_folder(tmp_path)
    done = run_without_ros(PAGE, folder)
    assert done.returncode == 0, done.stderr
    assert recording_in((folder / "run.html").read_text())["title"].startswith("room, harness")
