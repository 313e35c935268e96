"""The recording of a run through the whole graph: every topic, decoded whole, and the run as its files tell it."""

import csv
import io

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from collplan_core.parameters.file import write_values
from collplan_core.warm_up import warm_up
from collplan_ros.bringup.driving import wait_until_ready
from collplan_ros.bringup.main import Bringup, write_results
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.progress import Progress
from collplan_ros.run.description import END
from collplan_ros.run.reader import attachment, description
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.topics import recorded_topics
from collplan_ros.run.writer import RECORDING

ALWAYS = {
    "/mocap/pose", "/mocap/odom", "/scan", "/goal_pose", "/goal_status", "/plan", "/planner/trajectory",
    "/planner/heartbeat", "/planner/costs", "/cmd_vel", "/maneuver",
    "/controller/state", "/controller/reference", "/robot/state", "/ground_truth/odom", "/diagnostics",
    "/shared_constants", "/parameter_events", "/rosout",
}  # fmt: skip


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Folder of a run, the topics of its graph, its settings, and the log of its record."""
    warm_up()
    path = tmp_path_factory.mktemp("runs")
    # slowly: a busy machine may look late whether it is over
    write_values({"trial.timeout": 1.5, "robot.max_speed": 0.3}, path / "early.yaml")
    options = Options(seed=3, out=path, params=path / "early.yaml", pictures=False)
    with Bringup(options, Progress(io.StringIO())) as bringup:
        wait_until_ready(bringup)
        outcome = bringup.drive()
        assert outcome == "timeout"
        names = {name for name, _ in bringup.listener.node.get_topic_names_and_types()}
        bringup.come_to_rest()
    folder = bringup.folder.path
    run = read_run(folder)
    write_results(run, bringup.preparation, outcome)
    return folder, names, bringup.preparation.settings, run.log


def test_a_run_that_is_over_is_canceled_and_recorded_until_the_robot_rests(ran):
    folder, _, _, log = ran
    assert description(folder / RECORDING, END)
    moves = [bool(c.vx or c.vy or c.wz) for c in log.sent_commands]
    assert any(moves)
    assert not moves[-1]
    rows = csv.DictReader((folder / "trajectory.csv").open())
    speeds = [np.hypot(float(row["vx"]), float(row["vy"])) for row in rows]
    assert speeds[-1] < 0.03
    assert max(speeds) > 0.1
    assert "goal canceled" in (folder / "log" / "planner_node.log").read_text()


def test_every_topic_of_the_graph_is_in_it(ran):
    folder, names, settings, _ = ran
    known = {name if name.startswith("/") else f"/{name}" for name in recorded_topics(settings)}
    assert names - known == {"/planner/markers"}  # for RViz alone
    path = folder / RECORDING
    with AnyReader([path]) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)
    assert counts.keys() >= ALWAYS


def test_it_says_what_the_run_was(ran):
    path = ran[0] / RECORDING
    assert attachment(path, "parameters.yaml") == (ran[0] / "parameters.yaml").read_text()
    assert 'name: "corridor"' in attachment(path, "world.yaml")
    assert (description(path, "run")["simulated"], description(path, "run")["namespace"]) == ("true", "/")
    assert description(path, "version").keys() >= {"collplan-core", "numpy", "numba", "python", "sources"}
