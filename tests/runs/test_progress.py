"""What is said of a run: nobody has to read it."""

import io
import subprocess
import sys

from collplan_ros.bringup.progress import Progress

TALKS_ON = """
import sys
from collplan_ros.bringup.progress import Progress

progress = Progress()
progress.say("begun")
sys.stdin.readline()
for k in range(100):
    progress.say("goes on")
progress._last = 0.0
progress.show(1.0, 2.0, "free_space", 0)
sys.exit(7)
"""


def test_a_reader_that_has_gone_ends_nothing_and_is_not_complained_about():
    pipes = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    with subprocess.Popen([sys.executable, "-c", TALKS_ON], **pipes) as talker:
        assert talker.stdout.readline() == b"begun\n"
        talker.stdout.close()
        talker.stdin.write(b"\n")
        talker.stdin.close()
        assert talker.stderr.read() == b""
        assert talker.wait(60.0) == 7


def test_a_disk_that_is_full_ends_nothing_either():
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-c", TALKS_ON.replace("sys.stdin.readline()", "")]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (7, b"")


def test_a_program_started_without_standard_output_goes_on_too():
    code = TALKS_ON.replace("sys.stdin.readline()", "")
    command = ["sh", "-c", 'exec "$0" -c "$1" >&-', sys.executable, code]
    done = subprocess.run(command, stderr=subprocess.PIPE, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (7, b"")


def test_lines_of_a_file_follow_each_other():
    said = io.StringIO()
    progress = Progress(said)
    progress.show(1.0, 2.0, "free_space", 0, "0.85x real time")
    progress.say("end")
    assert said.getvalue() == "   1.0 s   2.00 m to the goal  free_space          impacts 0, 0.85x real time\nend\n"


def test_no_time_is_said_before_it_has_come():
    """A run that ends after 2.88 s says nothing of 2.9 s before."""
    said = io.StringIO()
    Progress(said).show(2.86, 0.11, "free_space", 0)
    assert said.getvalue().startswith("   2.8 s   0.11 m")
