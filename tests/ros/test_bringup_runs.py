"""Runs of bringup in this process, of a robot and a planner that do what the test says: how each ends."""

import io
import json
import math
import os
import signal
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from functools import partial
from threading import Event

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped, Twist, Vector3
from rcl_interfaces.msg import Log
from rclpy.node import Node
from std_srvs.srv import Trigger

from collplan_ros.bringup import driving, preparation, watching
from collplan_ros.bringup.driving import wait_until_ready
from collplan_ros.bringup.ending import GraphError
from collplan_ros.bringup.main import Bringup, main, run
from collplan_ros.bringup.options import ROBOTS, Options, RobotKind
from collplan_ros.bringup.progress import Progress
from collplan_ros.messages import qos
from collplan_ros.node_kit.reachability import PROFILE, RANGE
from collplan_ros.run.recorded_run import read_run
from fake_robot import FakeRobot, hall

LATCHED = {"goal_status": GoalStatus, "robot/state": DiagnosticStatus, "/diagnostics": DiagnosticArray, "/rosout": Log}
HEALTH = {"/fake_robot": "", "/planner_node": "no way", "/robot1/fake_robot": ""}


class Played:
    """All nodes that bringup hears of; a goal meets what the test says, and every `deaf`-th wish to end it is heard."""

    def __init__(self, ros) -> None:
        self.robot, self.goals, self.asked, self.deaf, self.meet = FakeRobot(ros, hall()), 0, 0, 1, self.succeed
        self.out = {name: ros.probe.create_publisher(kind, name, qos.LATCHED) for name, kind in LATCHED.items()}
        self.controller = ros.make(lambda **kwargs: Node("controller_node", **kwargs))
        self.teleop = ros.make(lambda **kwargs: Node("teleop", namespace="/far", **kwargs))
        self.commands = self.controller.create_publisher(Twist, "cmd_vel", qos.NEWEST_PUBLISHED)
        ros.probe.create_subscription(PoseStamped, "goal_pose", self.take_goal, qos.EVENT)
        ros.probe.create_service(Trigger, "cancel", self.cancel)
        health = [DiagnosticStatus(name=name, message=message) for name, message in HEALTH.items()]
        self.out["/diagnostics"].publish(DiagnosticArray(status=health))
        self.tell("free")

    def tell(self, state, message=""):
        said = {"state": state, "knows_planner": "yes", "reason": message}
        values = [KeyValue(key=key, value=value) for key, value in said.items()]
        self.out["robot/state"].publish(DiagnosticStatus(message=message, values=values))

    def take_goal(self, _):
        self.goals += 1
        self.commands.publish(Twist(linear=Vector3(x=0.3)))
        self.out["goal_status"].publish(GoalStatus(status=GoalStatus.STATUS_EXECUTING))
        self.meet()

    def cancel(self, _, response):
        self.asked += 1
        if self.asked % self.deaf == 0:
            self.end(GoalStatus.STATUS_CANCELED)
        return response

    def end(self, status):
        self.commands.publish(Twist())
        self.out["goal_status"].publish(GoalStatus(status=status))

    def succeed(self):
        self.end(GoalStatus.STATUS_SUCCEEDED)

    def drive_on(self):
        self.robot.velocity = np.array([0.4, 0.0])
        self.succeed()

    def be_held_at_last(self):
        self.succeed()
        self.tell("held", "the base drives on")

    def fall_silent_on_the_way_back(self):
        self.succeed()
        if self.goals == 2:
            watching.INPUT_PATIENCE, self.robot.poses_on = 0.5, False

    def be_interrupted_on_the_way_back(self):
        self.succeed() if self.goals == 1 else os.kill(os.getpid(), signal.SIGINT)

    def log(self):
        for name, level, text in LOGGED:
            self.out["/rosout"].publish(Log(name=name, level=level, msg=text))


LOGGED = (
    ("fake_robot", 40, "drives on"),
    ("fake_robot", 30, "watchdog is 0"),
    ("fake_robot", 20, "ready"),
    ("robot1.fake_robot", 40, "of another robot"),
    ("elsewhere", 40, "of another node"),
)
"""Name, level and text."""


@pytest.fixture
def options(tmp_path, monkeypatch):
    (tmp_path / "node").write_text("#!/bin/sh\nexec sleep 60\n")
    (tmp_path / "node").chmod(0o755)
    (tmp_path / "set.yaml").write_text("/**: {ros__parameters: {trial.timeout: 1.0, mocap.topic: /vicon/body}}\n")
    monkeypatch.setattr(preparation, "NODES", ())
    monkeypatch.setattr(preparation, "find_executable", lambda name: str(tmp_path / "node"))
    monkeypatch.setitem(ROBOTS, "fake", RobotKind(("fake_robot",), True))
    monkeypatch.setattr(driving, "PAUSE", 0.0)
    monkeypatch.setattr(driving, "REST_PATIENCE", 1.0)
    monkeypatch.setattr(watching, "INPUT_PATIENCE", watching.INPUT_PATIENCE)
    return Options(robot="fake", out=tmp_path / "runs", params=tmp_path / "set.yaml", pictures=False)


@pytest.fixture
def played(ros):
    """In a thread of its own, whose poses are not held up by what is compiled for the first scan."""
    nodes, over = Played(ros), Event()
    nodes.robot.scan()
    with ThreadPoolExecutor() as pool:
        spinning = pool.submit(ros.wait_until, over.is_set, 60.0)
        yield nodes
        over.set()
    assert spinning.result()


def test_each_end_of_a_goal_is_an_outcome_and_what_has_not_ended_is_canceled(played, options):
    bringup = Bringup(options, Progress(io.StringIO()))
    with closing(bringup.folder), bringup:
        wait_until_ready(bringup)
        for outcome, meet, words, asked, deaf in (
            ("reached", played.succeed, "", 0, 1),
            ("aborted", lambda: played.end(GoalStatus.STATUS_ABORTED), "no way", 0, 1),
            ("canceled", lambda: played.end(GoalStatus.STATUS_CANCELED), "", 0, 1),
            ("timeout", lambda: None, "planner_node: no way", 2, 2),
            ("timeout", lambda: played.tell("held", "no fresh command"), "robot is held: no fresh command", 2, 2),
            ("emergency_stop", lambda: played.tell("stopped", "button"), "button", 2, 1000),
        ):
            played.meet, played.asked, played.deaf = meet, 0, deaf
            assert bringup.drive(np.array([1.0, 0.5])) == outcome
            assert words in bringup.reason(outcome), outcome
            bringup.come_to_rest()
            # whom nobody hears does not wait: to leave the graph stops the robot
            assert bringup.listener.at_rest == (deaf < 1000), outcome
            assert (min(played.asked, 2), played.asked < 10) == (asked, True), outcome
        bringup.recorder.blind = math.pi
        assert "the LIDAR sees 180 of 360 degrees" in bringup.reason("timeout")
        played.teleop.create_publisher(Twist, "/cmd_vel", 1)
        with pytest.raises(GraphError, match="by /far/teleop beside controller_node"):
            bringup.wait(lambda: False)


@pytest.mark.parametrize(
    ("meet", "code", "outcome", "reason"),
    [
        (Played.succeed, 0, "reached", ""),
        (lambda _: None, 1, "timeout", "planner_node: no way"),
        (Played.drive_on, 3, "drives_on", "the robot drives on at 0.40 m/s"),
        (Played.be_held_at_last, 3, "drives_on", "then the robot was held: the base drives on"),
        (Played.fall_silent_on_the_way_back, 3, "graph_lost", "nothing on /mocap/odom"),
        (Played.be_interrupted_on_the_way_back, 0, "interrupted", "Ctrl-C"),
    ],
)
def test_how_a_run_ends_is_its_exit_code_and_its_folder(played, options, capsys, meet, code, outcome, reason):
    played.meet = partial(meet, played)
    given = ["--robot", "fake", "--out", str(options.out), "--params", str(options.params), "--no-pictures"]
    assert main([*given, *["--again"] * (outcome in ("graph_lost", "interrupted"))]) == code
    said, folder = capsys.readouterr().out, options.out / "latest"
    summary = json.loads((folder / "summary.json").read_text())
    assert (summary["outcome"], summary["reached"]) == (outcome, outcome == "reached")
    assert reason in summary["reason"]
    assert (reason or "goal reached in") in said
    assert read_run(folder).note == ""


def test_with_a_kept_emergency_stop_no_goal_is_given_and_it_is_said_how_to_clear_it(played, options):
    played.tell("stopped", "button")
    result = run(options)
    assert (result.exit_code, played.goals, "/clear_estop" in result.message) == (3, 0, True)


def test_without_poses_it_is_said_where_they_were_expected(played, options):
    watching.INPUT_PATIENCE = 0.5
    before = {key: os.environ[key] for key in ("ROS_DOMAIN_ID", RANGE, PROFILE)}
    result = run(replace(options, network="subnet", namespace="/robot1"))
    assert (result.outcome, result.exit_code) == ("graph_lost", 3)
    domain = f"domain {before['ROS_DOMAIN_ID']}"
    for words in ("/robot1/mocap/odom", domain, "subnet", "/vicon/body", "/robot1/mocap/pose"):
        assert words in result.message
    assert {key: os.environ[key] for key in before} == before


def test_progress_that_nobody_reads_any_more_ends_nothing():
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as stream:
        Progress(stream).say("into the void")


@pytest.mark.parametrize(("simulated", "said"), [(True, LOGGED[:1]), (False, LOGGED[:2])])
def test_errors_of_the_nodes_are_said_when_they_happen_and_why_a_real_robot_stands(
    played, options, monkeypatch, simulated, said
):
    monkeypatch.setitem(ROBOTS, "fake", RobotKind(("fake_robot",), simulated))
    output = io.StringIO()
    asked = replace(options, world="corridor", goal=(2.0, 0.4), network="local")
    bringup = Bringup(asked, Progress(output))
    with closing(bringup.folder), bringup:
        wait_until_ready(bringup)
        played.log()
        end = bringup.now() + 5.0
        bringup.wait(lambda: said[-1][2] in output.getvalue() or bringup.now() > end)
        bringup.step()
    assert tuple(row for row in LOGGED if row[2] in output.getvalue()) == said


@pytest.mark.parametrize("code", [1, 2])
def test_a_node_that_ends_at_its_start_is_named_with_its_last_lines(options, capsys, code):
    (options.out.parent / "node").write_text(f"#!/bin/sh\necho no such port\nexit {code}\n")
    result = run(options)
    assert (result.outcome, result.exit_code) == ("node_died", {1: 3, 2: 2}[code])
    assert result.summary["reason"].endswith(f"fake_robot ended with exit code {code}")
    assert ":\n  no such port\n" in capsys.readouterr().out
