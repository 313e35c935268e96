"""What installed programs start: Ctrl-C during imports ends them quietly, later it is theirs."""

import os
import signal
import subprocess
import sys

import pytest

PROGRAM = """
import time
{importing}
def main():
    try:
        {running}
    except KeyboardInterrupt:
        return 7
"""
WAITING = "print('here', flush=True); time.sleep(60)"


def interrupted(tmp_path, importing, running, *, ignoring=False):
    (tmp_path / "program.py").write_text(PROGRAM.format(importing=importing, running=running))
    start = "from collplan_core.command_line import Executable; raise SystemExit(Executable('program')())"
    # said either way: a test run in the background ignores it and leaves that to its children
    handler = "SIG_IGN" if ignoring else "default_int_handler"
    start = f"import signal; signal.signal(signal.SIGINT, signal.{handler}); {start}"
    process = subprocess.Popen(
        [sys.executable, "-c", start],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])},
    )
    assert process.stdout.readline() == "here\n"
    process.send_signal(signal.SIGINT)
    errors = process.communicate(timeout=30.0)[1]
    return process.returncode, errors


def test_ctrl_c_ends_it_without_a_word_during_imports_and_is_its_own_later(tmp_path):
    assert interrupted(tmp_path, importing=WAITING, running="pass") == (-signal.SIGINT, "")
    assert interrupted(tmp_path, importing="", running=WAITING) == (7, "")


def test_a_program_that_was_started_to_ignore_it_goes_on(tmp_path):
    for where in ("importing", "running"):
        program = {"importing": "", "running": "pass"} | {where: WAITING.replace("60", "0.2")}
        assert interrupted(tmp_path, **program, ignoring=True) == (0, "")


@pytest.mark.parametrize("content", ["raise ImportError('of Python 3.10')", "print 'of Python 2'", ""])
def test_a_package_of_another_ros_on_the_path_is_one_sentence(tmp_path, content):
    other, ours = tmp_path / "other", tmp_path / "ours"
    for folder in (other / "rclpy", ours):
        folder.mkdir(parents=True)
    (other / "rclpy" / "__init__.py").write_text(content)
    (ours / "program.py").write_text("from rclpy.clock import Clock")
    start = "from collplan_core.command_line import Executable; raise SystemExit(Executable('program')())"
    paths = os.pathsep.join([str(other), str(ours), os.environ.get("PYTHONPATH", "")])
    env = os.environ | {"PYTHONPATH": paths}
    done = subprocess.run([sys.executable, "-c", start], env=env, capture_output=True, text=True, timeout=60)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1), done.stderr
    assert f"PYTHONPATH holds {other}, of another Python or ROS?" in done.stderr
