"""bringup as a process: however it ends the robot rests, recorded until it does, and no process stays behind."""

import os
import re
import signal
import time

import pytest
from bringup_process import IN_PROCESSES, NODES, SLOWLY, Run, nodes_of, wait_for

from collplan_core.parameters.file import write_values
from collplan_core.warm_up import warm_up
from collplan_ros.run.reader import description, raw_messages
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


@pytest.mark.soak
def test_two_robots_in_a_domain_reach_their_goals_each_by_its_own_clock(tmp_path):

    def at_speed(factor: float) -> list[str]:
        path = tmp_path / f"{factor}.yaml"
        write_values({"simulator.speed_factor": factor}, path)
        return ["--no-pictures", "--processes", "--world", "slalom", "--params", str(path)]

    with (
        Run(tmp_path / "one", "--namespace", "robot1", *at_speed(0.25)) as one,
        Run(tmp_path / "two", "--namespace", "/robot2", *at_speed(0.5)) as two,
    ):
        assert (one.end(), two.end()) == (0, 0), one.text + two.text
    for robot, namespace in ((one, "/robot1"), (two, "/robot2")):
        assert robot.summary()["outcome"] == "reached"
        recording = robot.out / "latest" / RECORDING
        assert description(recording, "run")["namespace"] == namespace
        assert len(list(raw_messages(recording, ["goal_status"]))) >= 3
        assert list(raw_messages(recording, ["clock"]))


ALONE = pytest.param(SLOWLY, set(), marks=pytest.mark.soak)


@pytest.mark.parametrize(("options", "nodes"), [ALONE, (IN_PROCESSES, NODES)])
def test_ctrl_c_stops_everything_in_order(tmp_path, options, nodes):
    with Run(tmp_path / "runs", *options) as run:
        wait_for(run.moving)
        assert nodes_of(run.out).keys() == nodes
        run.process.send_signal(signal.SIGINT)
        assert run.end() == 128 + signal.SIGINT, run.text
    assert nodes_of(run.out) == {}
    assert run.summary()["outcome"] == "interrupted"
    said = "".join(log.read_text() for log in (run.out / "latest" / "log").iterdir())
    assert "Traceback" not in said + run.text
    assert "killed" not in run.text


@pytest.mark.soak
def test_no_node_outlives_a_bringup_killed_at_any_moment_of_its_start(tmp_path):
    for k in range(10):
        with Run(tmp_path / f"runs_{k}", "--no-pictures", "--processes") as run:
            wait_for(lambda run=run: (run.out / "latest").is_symlink())
            time.sleep(0.008 * k)
            run.process.kill()
            run.end()
            wait_for(lambda run=run: not nodes_of(run.out))
