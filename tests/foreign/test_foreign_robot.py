"""A robot that is not ours, by its topics alone: ir-sim's kinematics and LIDAR, an odometry that slips and drifts."""

import itertools
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml
from bringup_process import Run, nodes_of
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Twist
from real_messages import INSTALLED, MODULES
from std_msgs.msg import String

from collplan_ros.messages.qos import LATCHED
from rooms import RADIUS, ROOMS, write_world

HERE = Path(__file__).parent
GOALS = 7
"""In each room: 21 with a strategy."""
CASES = 20
STANDS, DRIVES = 0.05, 0.5
"""[m/s]"""
BRAKING = 0.8 / 1.5 + 3 * 0.1
"""From full speed, and until what its lag leaves has gone [s]."""
UNTIL_ZERO = {"stopped": 0.35, "killed": 0.5, "late": 2.0, "reversed": 1.5, "deaf": 3.0}
"""From the fault until it brakes, or until a deaf one is told of beyond the way to brake [s]."""
SLACK = 0.25
"""Of the messages between this process and the others [s]."""
LONG = [pytest.mark.soak, pytest.mark.timeout(3600)]
PARAMETERS = {
    "robot": {"radius": RADIUS, "mass": 3.0, "max_speed": 0.8, "max_acceleration": 1.5, "velocity_lag": 0.1},
    "cap": {"speed": 0.8},
    "limits": {"impact_speed": 0.8},
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
def robot_in(room: str, folder: Path) -> Iterator[None]:
    """The robot, from its process's first scan on."""
    world = write_world(ROOMS[room], folder / f"{room}.yaml")
    command = [sys.executable, str(HERE / "irsim_robot.py"), str(world), "1"]
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


def touches(truths: list[Twist]) -> int:
    return round(truths[-1].angular.z) if truths else 0


def speed(truths: list[Twist]) -> float:
    return math.hypot(truths[-1].linear.x, truths[-1].linear.y) if truths else 0.0


def test_a_goal_in_its_own_map_without_a_touch(ros, foreign, tmp_path):
    truths = ros.listen(Twist, "/truth")
    with robot_in("hall", tmp_path), drive(tmp_path, "avoid", ROOMS["hall"].goals[0]) as run:
        assert run.end() == 0, run.text
        ros.spin(0.1)
        assert run.summary()["simulated"] is False
    assert truths
    assert not touches(truths)


@pytest.mark.parametrize("strategy", ["avoid", "bounce", "harness"])
@pytest.mark.parametrize("room", [pytest.param(room, marks=LONG) for room in ROOMS])
def test_every_goal_of_a_room(ros, foreign, tmp_path, room, strategy):
    truths = ros.listen(Twist, "/truth")
    with robot_in(room, tmp_path):
        for goal in itertools.islice(itertools.cycle((*ROOMS[room].goals, ROOMS[room].start)), GOALS):
            with drive(tmp_path, strategy, goal) as run:
                assert run.end() == 0, run.text
        ros.spin(0.1)
    print(f"{room} {strategy}: {GOALS} goals, {touches(truths)} touches")
    assert strategy != "avoid" or not touches(truths)


@pytest.mark.parametrize("fault", [pytest.param(fault, marks=LONG) for fault in UNTIL_ZERO])
def test_it_stands_in_time_and_a_deaf_base_is_told_of(ros, foreign, tmp_path, fault):
    times = []
    for case in range(CASES):
        truths, states = ros.listen(Twist, "/truth"), ros.listen(DiagnosticStatus, "/collplan/robot/state", LATCHED)
        folder = tmp_path / f"{case}"
        folder.mkdir()
        with robot_in("hall", folder), drive(folder, "avoid", ROOMS["hall"].goals[0]) as run:
            assert ros.wait_until(lambda truths=truths: speed(truths) > DRIVES, 60.0), run.text
            begun = time.monotonic()
            if fault == "killed":
                os.kill(nodes_of(run.out)["base_node"], signal.SIGKILL)
            else:
                ros.publisher(String, "/fault").publish(String(data=fault))
            is_over = {
                "deaf": lambda states=states: any("drives on" in each.message for each in states),
            }.get(fault, lambda truths=truths: speed(truths) < STANDS)
            assert ros.wait_until(is_over, 20.0), run.text
            times.append(time.monotonic() - begun)
    print(f"{fault}: {CASES} times, {min(times):.2f} to {max(times):.2f} s")
    assert max(times) <= UNTIL_ZERO[fault] + BRAKING + SLACK
