"""How a run ends on the real graph: the robot rests, recorded until it does, whatever ended it."""

import csv
import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from bringup_process import Run, nodes_of, wait_for
from rclpy.context import Context
from rclpy.node import Node
from std_srvs.srv import Trigger

from collplan_core.warm_up import warm_up
from collplan_ros.bringup.commanders import other_commanders
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.main import CANCEL_PATIENCE, CANCEL_PERIOD, Bringup, run
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.progress import Progress
from collplan_ros.recording.completion import KILLED, complete
from collplan_ros.recording.reading import raw_messages
from collplan_ros.recording.recording_file import RECORDING
from collplan_ros.runs.record_reading import RECORD, read_record
from collplan_ros.runs.recorded_run import read_run
from collplan_ros.runs.run_error import RunError
from collplan_ros.runs.run_log import RunLog

AT_ONCE = 0.1
"""Longest time from the outcome of a run to the first zero command [s]."""
AT_REST = 0.03
"""[m/s]"""
LOST = 1.0
"""What a killed bringup may lose of a run at most [s]."""


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    warm_up()


def ends_early(folder: Path, **trial: float) -> Path:
    """A parameter file under which a run ends while the robot drives."""
    file = folder / "early.yaml"
    file.write_text(f"/**:\n  ros__parameters:\n    trial: {json.dumps(trial)}\n")
    return file


def last_commands(log: RunLog) -> tuple[float, float]:
    """When the last command to move and the zero after it were sent [s, steady clock]."""
    moving = [k for k, c in enumerate(log.sent_commands) if c.vx or c.vy or c.wz]
    return log.sent_commands[moving[-1]].sent, log.sent_commands[moving[-1] + 1].sent


@pytest.fixture
def ended(monkeypatch):
    """When the outcome of each run of this process was known [s]."""
    times = []
    come_to_rest = Bringup.come_to_rest

    def noted(self):
        times.append(time.monotonic())
        come_to_rest(self)

    monkeypatch.setattr(Bringup, "come_to_rest", noted)
    return times


@pytest.mark.parametrize(
    ("outcome", "limits"),
    [
        pytest.param("timeout", {"timeout": 1.5}, marks=pytest.mark.soak),
        pytest.param("stuck", {"stuck_time": 0.5, "stuck_distance": 1.0}, marks=pytest.mark.soak),
    ],
)
def test_a_run_that_is_over_is_canceled_at_once_and_recorded_until_the_robot_rests(tmp_path, ended, outcome, limits):
    said = io.StringIO()
    options = Options(out=tmp_path / "runs", pictures=False, params=ends_early(tmp_path, **limits))
    result = run(options, Progress(said))
    assert (result.outcome, result.exit_code) == (outcome, 1), said.getvalue()
    record = read_record(result.folder / RECORD)
    _, zero = last_commands(record.log)
    assert '\n["end",' in (result.folder / RECORD).read_text()
    assert zero - ended[0] <= AT_ONCE, said.getvalue()
    rows = list(csv.DictReader((result.folder / "trajectory.csv").open()))
    assert np.hypot(float(rows[-1]["vx"]), float(rows[-1]["vy"])) < AT_REST
    assert max(np.hypot(float(row["vx"]), float(row["vy"])) for row in rows) > 0.2
    assert "goal canceled" in (result.folder / "log" / "planner_node.log").read_text()


@pytest.mark.soak
@pytest.mark.parametrize(
    ("deaf", "patience"), [pytest.param(1, CANCEL_PERIOD, id="once"), pytest.param(1000, CANCEL_PATIENCE, id="always")]
)
def test_a_planner_that_is_not_reached_is_asked_again_and_then_the_controller_is_stopped(
    tmp_path, monkeypatch, ended, deaf, patience
):
    asked = []
    cancel_goal = Graph.cancel_goal

    def unheard(self):
        asked.append(time.monotonic())
        if len(asked) > deaf:
            cancel_goal(self)

    monkeypatch.setattr(Graph, "cancel_goal", unheard)
    said = io.StringIO()
    options = Options(out=tmp_path / "runs", pictures=False, params=ends_early(tmp_path, timeout=1.5))
    result = run(options, Progress(said))
    assert result.outcome == "timeout", said.getvalue()
    _, zero = last_commands(read_record(result.folder / RECORD).log)
    assert zero - ended[0] <= patience + 2 * AT_ONCE, said.getvalue()


@pytest.mark.soak
def test_a_kept_emergency_stop_waits_for_a_person_and_nothing_drives_off_by_its_clearing(ros, tmp_path):
    with Run(tmp_path / "runs", "--no-pictures") as run:
        assert ros.call(Trigger, "estop", timeout=60.0).success
        wait_for(lambda: "call /clear_estop" in run.text)
        assert run.process.poll() is None
        assert ros.call(Trigger, "clear_estop").success
        assert run.end() == 3, run.text
    assert "the emergency stop is cleared: start again to drive" in run.text
    assert "until it is cleared" in run.text
    assert "free_space" not in run.text


@pytest.mark.parametrize("how", ["cancel", *(pytest.param(how, marks=pytest.mark.soak) for how in ("estop", "signal"))])
def test_zero_follows_at_once_on_whatever_ends_a_run(ros, tmp_path, how):
    with Run(tmp_path / "runs", "--no-pictures") as run:
        wait_for(run.moving)
        client = None if how == "signal" else ros.probe.create_client(Trigger, how)
        assert client is None or ros.wait_until(client.service_is_ready)
        assert run.process.poll() is None, run.text
        begun = time.monotonic()
        if client is None:
            run.process.send_signal(signal.SIGINT)
        else:
            answer = client.call_async(Trigger.Request())
            assert ros.wait_until(answer.done)
        assert run.end() == (128 + signal.SIGINT if client is None else 1), run.text
    _, zero = last_commands(read_record(run.out / "latest" / RECORD).log)
    assert 0.0 < zero - begun <= 2 * AT_ONCE, run.text


@pytest.mark.soak
@pytest.mark.parametrize(("node", "outcome"), [("planner_node", "stuck"), ("simulator_node", "graph_lost")])
def test_a_frozen_node_is_named_where_it_ends_the_run(tmp_path, node, outcome):
    with Run(tmp_path / "runs", "--no-pictures") as run:
        wait_for(run.moving)
        pid = nodes_of(run.out)[node]
        os.kill(pid, signal.SIGSTOP)
        try:
            assert run.end() == (1 if outcome == "stuck" else 3), run.text
        finally:
            if node in nodes_of(run.out):
                os.kill(pid, signal.SIGCONT)
    assert re.search(rf"; frozen: nothing on /diagnostics from {node} for \d\.\d s", run.text), run.text
    assert run.summary()["outcome"] == outcome


# ---- a second commander

ROGUE = """
import rclpy, sys, time
from geometry_msgs.msg import Twist
rclpy.init()
node = rclpy.create_node("rogue")
publisher = node.create_publisher(Twist, "cmd_vel", 1)
print("up", flush=True)
while True:
    rclpy.spin_once(node, timeout_sec=0.02)
"""


@pytest.mark.soak
def test_a_second_commander_is_named_and_ends_the_run(tmp_path):
    with Run(tmp_path / "runs", "--no-pictures") as run:
        wait_for(run.moving)
        rogue = subprocess.Popen([sys.executable, "-c", ROGUE], stdout=subprocess.PIPE)
        try:
            assert rogue.stdout.readline() == b"up\n"
            begun = time.monotonic()
            wait_for(lambda: "/rogue" in run.text, patience=5.0)
            noticed = time.monotonic() - begun
            assert run.end() == 3, run.text
        finally:
            rogue.kill()
            rogue.wait()
    assert "/cmd_vel is published by /rogue beside controller_node; end all but controller_node" in run.text
    assert noticed < 2.0
    assert nodes_of(run.out) == {}


def test_the_commander_is_told_from_others(ros):
    from geometry_msgs.msg import Twist

    def others() -> list[str]:
        return other_commanders(ros.probe, "controller_node")

    context = Context()
    context.init()
    nodes = [Node("controller_node", context=context), Node("teleop", namespace="/far", context=context)]
    try:
        nodes[0].create_publisher(Twist, "cmd_vel", 1)
        ros.spin(0.5)
        assert others() == []
        nodes[1].create_publisher(Twist, "/cmd_vel", 1)
        assert ros.wait_until(lambda: others() == ["/far/teleop"])
    finally:
        for node in nodes:
            node.destroy_node()
        context.shutdown()


# ---- what is left of a run that was killed, or whose disk is full


def test_a_killed_bringup_loses_a_second_at_most(tmp_path):
    """Fifty times: `make faults-long`."""
    with Run(tmp_path / "runs", "--no-pictures", "--world", "serpentine:0") as run:
        wait_for(run.moving)
        # one that is killed within its first second may leave nothing
        wait_for(run.has_recorded)
        assert run.process.poll() is None, run.text
        folder = (run.out / "latest").resolve()
        with pytest.raises(RunError, match="is being written, and left as it is"):
            complete(folder)
        run.process.kill()
        killed, killed_ns = time.monotonic(), time.time_ns()
        run.end()
    left = read_run(folder)
    log = read_record(folder / RECORD, pictured=False).log
    assert killed - log.poses[-1].sent <= LOST
    assert len(left.path.times) == len(log.poses)
    assert "incomplete" in left.note
    wait_for(lambda: not nodes_of(run.out), patience=5.0)
    assert "summary.json and what goes with it are made" in complete(folder)
    assert run.summary()["outcome"] == KILLED
    assert len(read_run(folder).path.times) == len(log.poses)
    recorded = list(raw_messages(folder / RECORDING, ["mocap/odom"]))
    assert 1e-9 * (killed_ns - recorded[-1].sent) <= LOST
    assert len(recorded) >= len(log.poses)
    assert complete(folder) == f"{folder}: is whole"


FULL = """
import resource, signal, sys
from pathlib import Path
from collplan_ros.bringup.main import main
from collplan_ros.runs.recorder import Recorder

begin = Recorder.begin

def full(self, *given):
    begin(self, *given)
    out = Path(sys.argv[sys.argv.index("--out") + 1])
    largest = max((file.stat().st_size for file in out.rglob("run.mcap")), default=0)
    resource.setrlimit(resource.RLIMIT_FSIZE, (largest + 60_000, resource.RLIM_INFINITY))

Recorder.begin = full
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize(
    ("options", "full"), [(["--no-recording"], RECORD), pytest.param([], RECORDING, marks=pytest.mark.soak)]
)
def test_a_full_disk_ends_the_run_with_a_sentence_and_its_own_exit_code(tmp_path, options, full):
    with Run(tmp_path / "runs", "--no-pictures", *options, code=FULL) as run:
        assert run.end() == 4, run.text
    folder = (run.out / "latest").resolve()
    assert f"{folder / full}: cannot be written: File too large" in run.text
    assert "Traceback" not in run.text
    assert nodes_of(run.out) == {}
    assert len(read_record(folder / RECORD).log.poses) > 20
    rows = list(csv.DictReader((folder / "trajectory.csv").open()))
    assert all(None not in row.values() for row in rows)
    assert json.loads((folder / "summary.json").read_text())["outcome"] == "record_lost"


@pytest.mark.soak
def test_a_closed_stdout_ends_no_run(tmp_path):
    command = [sys.executable, "-m", "collplan_ros.bringup.main", "--no-pictures", "--out", str(tmp_path / "runs")]
    errors = tmp_path / "errors.txt"
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors.open("wb")) as process:
        process.stdout.readline()
        process.stdout.close()
        try:
            assert process.wait(100.0) == 0, errors.read_text()
        finally:
            process.kill()
    assert errors.read_text() == ""
    assert json.loads((tmp_path / "runs" / "latest" / "summary.json").read_text())["reached"]
