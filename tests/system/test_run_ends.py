"""How a run ends on the real graph: the robot rests, recorded until it does, whatever ended it."""

import csv
import io
import json
import os
import re
import signal
from pathlib import Path

import numpy as np
import pytest
from bringup_process import IN_PROCESSES, Run, nodes_of, wait_for

from collplan_core.warm_up import warm_up
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.progress import Progress
from collplan_ros.run.description import END
from collplan_ros.run.reader import description, raw_messages
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.result_files import KILLED, complete
from collplan_ros.run.run_log import RunLog
from collplan_ros.run.writer import RECORDING

AT_REST = 0.03
"""[m/s]"""


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    warm_up()


def ends_early(folder: Path, **trial: float) -> Path:
    """A parameter file under which a run ends while the robot drives, slowly: a busy machine may look at it late."""
    file, groups = folder / "early.yaml", {"trial": trial, "robot": {"max_speed": 0.3}}
    file.write_text(f"/**:\n  ros__parameters: {json.dumps(groups)}\n")
    return file


def stands_at_last(log: RunLog) -> bool:
    """Whether the robot was commanded to move, and zero at last."""
    moves = [bool(c.vx or c.vy or c.wz) for c in log.sent_commands]
    return any(moves) and not moves[-1]


def test_a_run_that_is_over_is_canceled_and_recorded_until_the_robot_rests(tmp_path):
    options = Options(out=tmp_path / "runs", pictures=False, params=ends_early(tmp_path, timeout=1.5))
    said = io.StringIO()
    result = run(options, Progress(said))
    assert (result.outcome, result.exit_code) == ("timeout", 1), said.getvalue()
    record = read_run(result.folder)
    assert description(result.folder / RECORDING, END)
    assert stands_at_last(record.log)
    rows = list(csv.DictReader((result.folder / "trajectory.csv").open()))
    assert np.hypot(float(rows[-1]["vx"]), float(rows[-1]["vy"])) < AT_REST
    assert max(np.hypot(float(row["vx"]), float(row["vy"])) for row in rows) > 0.1
    assert "goal canceled" in (result.folder / "log" / "planner_node.log").read_text()


@pytest.mark.soak
def test_a_frozen_node_is_named_where_it_ends_the_run(tmp_path):
    for node, outcome, code in (("planner_node", "stuck", 1), ("simulator_node", "graph_lost", 3)):
        with Run(tmp_path / node, *IN_PROCESSES) as run:
            wait_for(run.moving)
            pid = nodes_of(run.out)[node]
            os.kill(pid, signal.SIGSTOP)
            try:
                assert run.end() == code, run.text
            finally:
                if node in nodes_of(run.out):
                    os.kill(pid, signal.SIGCONT)
        assert re.search(rf"; frozen: .* {node} ", run.text), run.text
        assert run.summary()["outcome"] == outcome


# ---- what is left of a run that was killed


def test_the_run_of_a_killed_bringup_is_read_and_its_results_made_and_no_node_outlives_it(tmp_path):
    with Run(tmp_path / "runs", *IN_PROCESSES) as run:
        wait_for(run.moving)
        folder = (run.out / "latest").resolve()
        # one that is killed within its first second may leave nothing
        wait_for(run.has_recorded)
        assert run.process.poll() is None, run.text
        assert "being written" in complete(folder)
        run.process.kill()
        run.end()
    left = read_run(folder)
    assert "incomplete" in left.note
    wait_for(lambda: not nodes_of(run.out))
    assert "summary.json" in complete(folder)
    assert run.summary()["outcome"] == KILLED
    assert read_run(folder).log.poses == left.log.poses
    assert list(raw_messages(folder / RECORDING, ["mocap/odom"]))
