"""Recordings of the whole graph, replayed by the program without ROS."""

import subprocess
import sys

import pytest

from collplan_core.strategies import PAPER_WEIGHTS, TIME_TO_GOAL
from collplan_core.warm_up import warm_up
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import parse

STRATEGIES = (*PAPER_WEIGHTS, *TIME_TO_GOAL)
WORLDS = ("corridor", "u:17", "serpentine:2", "random:7")


def driven(out, world: str, strategy: str, seed: int):
    """The folder of a run of bringup; however it ended, it was recorded."""
    warm_up()
    asked = ["--world", world, "--strategy", strategy, "--seed", str(seed), "--out", str(out), "--no-pictures"]
    return run(parse([*asked, "--timeout", "6"])).folder


def replayed(folder) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "collplan_ros.replay.main", str(folder)]
    return subprocess.run(command, capture_output=True, text=True, timeout=100.0)


def assert_equal(folder) -> None:
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    done = replayed(folder)
    assert done.returncode == 0, done.stdout + done.stderr
    planner, controller = done.stdout.splitlines()
    assert int(planner.split()[1]) > 8
    assert int(controller.split()[1]) > 20
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before


def test_a_run_of_bringup_is_replayed_to_the_last_bit(tmp_path):
    assert_equal(driven(tmp_path, "u:17", "bounce", 1))


@pytest.mark.soak
def test_twenty_runs_of_bringup_are_replayed_to_the_last_bit(tmp_path):
    for seed in range(20):
        assert_equal(driven(tmp_path, WORLDS[seed % len(WORLDS)], STRATEGIES[seed % len(STRATEGIES)], seed))
