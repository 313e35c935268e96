"""A robot that is not ours, by its topics alone: ir-sim's kinematics and LIDAR, an odometry that slips and drifts.

Some of its faults are rows of `make faults`.
"""

import itertools
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import yaml
from bringup_process import Run
from nav_msgs.msg import Odometry

import foreign_robot
from rooms import ROOMS

GOALS = 7
"""In each room: 21 with a strategy."""
LONG = [pytest.mark.soak, pytest.mark.timeout(3600)]


@pytest.fixture
def foreign(monkeypatch):
    """The robot's program finds its messages, and so do the nodes of bringup."""
    if why := foreign_robot.missing():
        pytest.skip(why)
    for key, value in foreign_robot.environment().items():
        monkeypatch.setenv(key, value)


@contextmanager
def robot_in(room: str, folder: Path) -> Iterator[None]:
    process = foreign_robot.start(ROOMS[room], folder / f"{room}.yaml")
    try:
        yield
    finally:
        process.kill()
        process.wait()


def drive(folder: Path, strategy: str, goal: tuple[float, float]) -> Run:
    parameters = folder / "base.yaml"
    # its robot drives in real time: a stall of a busy machine looks late, which make faults judges
    limits = {**foreign_robot.PARAMETERS["limits"], "motion_delay": 0.4}
    values = {**foreign_robot.PARAMETERS, "limits": limits}
    parameters.write_text(yaml.safe_dump({"/**": {"ros__parameters": values}}))
    given = ("--robot", "base:/cmd_vel", "--scan", "real", "--network", "local", "--params", str(parameters))
    asked = ("--strategy", strategy, "--goal", *map(str, goal), "--max-speed", "0.8", "--timeout", "60")
    return Run(folder / f"{time.monotonic_ns()}", *given, *asked, "--no-pictures")


def touches(truths: list[Odometry]) -> int:
    return round(truths[-1].twist.twist.angular.z) if truths else 0


def test_a_goal_in_its_own_map_without_a_touch(ros, foreign, tmp_path):
    truths = ros.listen(Odometry, "/truth")
    with robot_in("hall", tmp_path), drive(tmp_path, "avoid", ROOMS["hall"].goals[0]) as run:
        assert run.end() == 0, run.text
        ros.spin(0.1)
        assert run.summary()["simulated"] is False
    assert truths
    assert not touches(truths)


@pytest.mark.parametrize("strategy", ["avoid", "bounce", "harness"])
@pytest.mark.parametrize("room", [pytest.param(room, marks=LONG) for room in ROOMS])
def test_every_goal_of_a_room(ros, foreign, tmp_path, room, strategy):
    truths = ros.listen(Odometry, "/truth")
    with robot_in(room, tmp_path):
        for goal in itertools.islice(itertools.cycle((*ROOMS[room].goals, ROOMS[room].start)), GOALS):
            with drive(tmp_path, strategy, goal) as run:
                assert run.end() == 0, run.text
        ros.spin(0.1)
    print(f"{room} {strategy}: {GOALS} goals, {touches(truths)} touches")
    assert strategy != "avoid" or not touches(truths)
