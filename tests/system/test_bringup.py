"""bringup as a process: it reaches the goal, and however it ends no process stays behind."""

import signal
import time

import pytest
from bringup_process import IN_PROCESSES, NODES, SLOWLY, Run, nodes_of, wait_for

from collplan_core.parameters.file import write_values
from collplan_core.warm_up import warm_up
from collplan_ros.run.reader import description, raw_messages
from collplan_ros.run.writer import RECORDING


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    """Four nodes that compile at once are slow; here they find it done."""
    warm_up()


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
