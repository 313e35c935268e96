"""How nodes start and end, as processes."""

import os
import signal
import subprocess
import sys
from pathlib import Path

from std_msgs.msg import String

from collplan_ros.messages.qos import NEWEST

PROGRAM = Path(__file__).with_name("nodes_to_run.py")


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
        output, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    return process.returncode, output, errors


def test_a_signal_ends_a_node_with_its_last_word(ros):
    heard = ros.listen(String, "words", NEWEST)
    process = start("talking")
    try:
        assert ros.wait_until(lambda: heard, timeout=60)
        process.send_signal(signal.SIGINT)
        assert ros.wait_until(lambda: heard[-1].data == "stopped", timeout=60)
    finally:
        code, output, errors = finish(process)
    assert (code, errors) == (0, "")
    assert output == "ready\nacknowledged True\n"


def test_a_signal_during_start_up_ends_what_may_compile_for_minutes():
    code, output, errors = finish(start("slow", SIGNAL="SIGTERM"))
    assert (code, output, errors) == (128 + signal.SIGTERM, "", "")


def test_callback_that_fails_stops_the_robot_first():
    code, output, errors = finish(start("failing"))
    assert code == 1
    assert "acknowledged True" in output
    assert "ZeroDivisionError" in errors


def parameter(setting):
    return ["--ros-args", "-p", setting]


def test_starts_that_fail_are_one_line_and_exit_code_2(tmp_path):
    file = tmp_path / "parameters.yaml"
    # a whole number will do for a float here too
    file.write_text("/**:\n  ros__parameters:\n    robot:\n      max_speed: 1\n    planner.map_periods: 0.2\n")
    cases = {
        "robot.max_speed: got 99.0": parameter("robot.max_speed:=99.0"),
        "none.yaml": ["--ros-args", "--params-file", "none.yaml"],
        "unrecognized arguments: -p robot.max_speed:=1.0": ["-p", "robot.max_speed:=1.0"],
        "planner.map_periods: unknown": ["--ros-args", "--params-file", str(file)],
    }
    running = {words: start("talking", *arguments) for words, arguments in cases.items()}
    for words, process in running.items():
        code, output, errors = finish(process)
        assert code == 2, (output, errors)
        assert words in errors
