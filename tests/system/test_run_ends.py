"""How a run ends on the real graph: the robot rests, recorded until it does, whatever ended it."""

import os
import re
import signal

import pytest
from bringup_process import IN_PROCESSES, Run, nodes_of, wait_for

from collplan_core.warm_up import warm_up
from collplan_ros.run.reader import raw_messages
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.result_files import KILLED, complete
from collplan_ros.run.writer import RECORDING


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    warm_up()


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
