"""How nodes start and end, as processes."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from std_msgs.msg import String

from collplan_ros.messages.qos import NEWEST

PROGRAM = Path(__file__).with_name("nodes_to_run.py")
SIGNALS = ["SIGINT", "SIGTERM"]


def start(kind, *arguments, **environment):
    return subprocess.Popen(
        [sys.executable, str(PROGRAM), kind, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **environment},
    )


def finish(process):
    try:
        output, errors = process.communicate(timeout=30)
    finally:
        process.kill()
    return process.returncode, output, errors


@pytest.mark.parametrize("name", SIGNALS)
def test_signal_ends_a_node_with_its_last_word(ros, name):
    heard = ros.listen(String, "words", NEWEST)
    process = start("talking")
    try:
        assert ros.wait_until(lambda: heard, timeout=30)
        process.send_signal(getattr(signal, name))
        assert ros.wait_until(lambda: heard[-1].data == "stopped", timeout=30)
    finally:
        code, output, errors = finish(process)
    assert (code, errors) == (0, "")
    assert output == "ready\nacknowledged True\n"


@pytest.mark.parametrize("name", SIGNALS)
def test_signal_during_start_up(name):
    code, output, errors = finish(start("slow", SIGNAL=name))
    assert (code, errors) == (0, "")
    assert "acknowledged True" in output


def test_callback_that_fails_stops_the_robot_first():
    code, output, errors = finish(start("failing"))
    assert code == 1
    assert "acknowledged True" in output
    assert "ZeroDivisionError" in errors


def parameter(setting):
    return ["--ros-args", "-p", setting]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (parameter("robot.max_sped:=1.0"), "robot.max_sped: unknown parameter, did you mean robot.max_speed"),
        (parameter("robot.max_speed:=99.0"), "robot.max_speed: got 99.0, expected a number in [0.05, 5] m/s"),
        (parameter("robot.max_speed:=.nan"), "robot.max_speed: got nan"),
        (["--ros-args", "--params-file", "none.yaml"], "none.yaml"),
        (["--ros-args", "--no-such-option"], "no-such-option"),
    ],
)
def test_start_that_fails_is_one_line_and_exit_code_2(arguments, words):
    code, output, errors = finish(start("talking", *arguments))
    assert (code, output) == (2, "")
    assert errors.count("\n") == 1
    assert words in errors


@pytest.mark.parametrize("said", ["mocap.topic:=pose", "talking:mocap.topic:=pose"])
def test_a_parameter_of_another_node_is_refused(said):
    code, _, errors = finish(start("talking", *parameter(said)))
    assert code == 2
    assert errors == "nodes_to_run.py: mocap.topic: no parameter of talking\n"


def test_forgotten_ros_args():
    code, _, errors = finish(start("talking", "-p", "robot.max_speed:=1.0"))
    assert code == 2
    assert "unrecognized arguments: -p robot.max_speed:=1.0" in errors


def test_parameter_file(tmp_path):
    """A whole number will do for a float here too."""
    file = tmp_path / "parameters.yaml"
    file.write_text("/**:\n  ros__parameters:\n    robot:\n      max_speed: 1\n    planner.map_periods: 0.2\n")
    code, _, errors = finish(start("talking", "--ros-args", "--params-file", str(file)))
    assert code == 2
    assert "planner.map_periods: unknown parameter" in errors
