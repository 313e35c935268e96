"""A robot that is not ours, by its topics alone: ir-sim's kinematics and LIDAR, an odometry that slips and drifts."""

import itertools
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml
from bringup_process import Run
from geometry_msgs.msg import Twist
from real_messages import INSTALLED, MODULES

from rooms import RADIUS, ROOMS, write_world

HERE = Path(__file__).parent
GOALS = 20
LONG = [pytest.mark.soak, pytest.mark.timeout(3600)]
PARAMETERS = {
    "robot": {"radius": RADIUS, "mass": 3.0, "max_speed": 0.8, "max_acceleration": 1.5, "velocity_lag": 0.1},
    "cap": {"speed": 0.8},
    "limits": {"impact_speed": 0.8},
    "scan": {"frame": "laser"},
    "mocap": {"format": "odometry", "topic": "/odom", "frame": "odom", "localised": True},
}


@pytest.fixture
def foreign(monkeypatch):
    """The robot's program finds its messages, and so do the nodes of bringup."""
    for package in ("tf2_msgs", "irsim"):
        if find_spec(package) is None and not (MODULES / package).is_dir():
            pytest.skip(f"{package} is missing: `make messages`, `make setup`")
    if MODULES.is_dir():
        monkeypatch.setenv("PYTHONPATH", str(MODULES), prepend=os.pathsep)
        monkeypatch.setenv("AMENT_PREFIX_PATH", str(INSTALLED), prepend=os.pathsep)
        # type support opens its libraries by their names
        monkeypatch.setenv("LD_LIBRARY_PATH", str(INSTALLED / "lib"), prepend=os.pathsep)
    monkeypatch.setenv("MPLBACKEND", "agg")


@contextmanager
def robot_in(room: str, folder: Path, *fault: str) -> Iterator[None]:
    """The robot, from its process's first scan on."""
    world = write_world(ROOMS[room], folder / f"{room}.yaml")
    command = [sys.executable, str(HERE / "irsim_robot.py"), str(world), "1", *fault]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    try:
        yield
    finally:
        process.kill()
        process.wait()


def drive(folder: Path, strategy: str, goal: tuple[float, float]) -> Run:
    parameters = folder / "base.yaml"
    parameters.write_text(yaml.safe_dump({"/**": {"ros__parameters": PARAMETERS}}))
    given = ("--robot", "base:/cmd_vel", "--scan", "real", "--network", "local", "--params", str(parameters))
    asked = ("--strategy", strategy, "--goal", *map(str, goal), "--max-speed", "0.8", "--timeout", "60")
    return Run(folder / f"{time.monotonic_ns()}", *given, *asked, "--no-pictures")


def test_a_goal_in_its_own_map_without_a_touch(ros, foreign, tmp_path):
    touches = ros.listen(Twist, "/touches")
    with robot_in("hall", tmp_path), drive(tmp_path, "avoid", ROOMS["hall"].goals[0]) as run:
        assert run.end() == 0, run.text
        ros.spin(0.1)
        assert run.summary()["simulated"] is False
    assert not touches


@pytest.mark.parametrize("strategy", ["avoid", "bounce", "harness"])
@pytest.mark.parametrize("room", [pytest.param(room, marks=LONG) for room in ROOMS])
def test_every_goal_of_a_room(ros, foreign, tmp_path, room, strategy):
    touches = ros.listen(Twist, "/touches")
    with robot_in(room, tmp_path):
        for goal in itertools.islice(itertools.cycle((*ROOMS[room].goals, ROOMS[room].start)), GOALS):
            with drive(tmp_path, strategy, goal) as run:
                assert run.end() == 0, run.text
        ros.spin(0.1)
    assert strategy != "avoid" or not touches
