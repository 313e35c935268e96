"""Run folders are read, compared, fitted, shown and replayed where ROS cannot be imported."""

import subprocess
import sys
from pathlib import Path

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
MAIN = """
from collplan_ros.{module} import main
sys.exit(main(sys.argv[1:]))
"""
PAGE = """
from pathlib import Path
from collplan_ros.view.player import write_run_page
write_run_page(Path(sys.argv[1]))
"""


def run_without_ros(program: str, *arguments: Path | str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-c", NO_ROS + program, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=100.0, check=False)


def test_ros_is_really_missing():
    assert "ModuleNotFoundError" in run_without_ros("import collplan_ros.runs.recorder").stderr


def test_runs_are_compared_and_a_robot_is_asked_for(tmp_path):
    folders = drawn_folder(tmp_path, "slow", 0.4, strategy="avoid"), drawn_folder(tmp_path, "fast", 0.3)
    done = run_without_ros(MAIN.format(module="pictures.compare_runs"), *folders, "--out", tmp_path / "beside.gif")
    assert done.returncode == 0, done.stderr
    done = run_without_ros(MAIN.format(module="runs.fit_robot"), *folders, "--out", tmp_path / "robot.yaml")
    assert (done.returncode, done.stderr[:11]) == (2, "fit_robot: ")


def test_a_trial_is_replayed(tmp_path):
    journal = tmp_path / "trial.jsonl"
    settings = Settings().with_values({"planner.strategy": "harness", "trial.timeout": 1.0})
    run_trial(load_world("corridor"), settings, 1, journal=journal)
    done = run_without_ros(MAIN.format(module="replay.main"), journal)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("bit-equal") == 2


def test_a_run_becomes_a_page(tmp_path):
    folder = played_folder(tmp_path)
    done = run_without_ros(PAGE, folder)
    assert done.returncode == 0, done.stderr
    assert recording_in((folder / "run.html").read_text())["title"].startswith("room, harness")
