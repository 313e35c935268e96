"""The recording of a run through the whole graph: every topic, decoded whole, and the run as its files tell it."""

import io

import pytest
from rosbags.highlevel import AnyReader

from collplan_core.parameters.file import read_parameters
from collplan_core.warm_up import warm_up
from collplan_core.worlds.file import parse_text
from collplan_ros.bringup.driving import wait_until_ready
from collplan_ros.bringup.main import Bringup, write_results
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.progress import Progress
from collplan_ros.run.reader import attachment, description, messages
from collplan_ros.run.recorded_run import read_run
from collplan_ros.run.topics import recorded_topics
from collplan_ros.run.writer import RECORDING

ALWAYS = {
    "/mocap/pose", "/mocap/odom", "/scan", "/goal_pose", "/goal_status", "/plan", "/planner/trajectory",
    "/planner/heartbeat", "/planner/costs", "/cmd_vel", "/maneuver",
    "/controller/state", "/controller/reference", "/robot/state", "/ground_truth/odom", "/diagnostics",
    "/shared_constants", "/parameter_events", "/rosout",
}  # fmt: skip
"""What comes in any run."""


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Folder of a run, the topics of its graph, what it was, and the log of its record."""
    warm_up()
    options = Options(seed=3, out=tmp_path_factory.mktemp("runs"), pictures=False)
    with Bringup(options, Progress(io.StringIO())) as bringup:
        wait_until_ready(bringup)
        outcome = bringup.drive()  # whatever it is: a busy machine may not get there
        names = {name for name, _ in bringup.listener.node.get_topic_names_and_types()}
        bringup.come_to_rest()
    folder = bringup.folder.path
    run = read_run(folder)
    write_results(run, bringup.preparation, outcome)
    return folder, names, bringup.preparation, run.log


def test_every_topic_of_the_graph_is_in_it_and_both_libraries_decode_it_whole(ran):
    folder, names, preparation, _ = ran
    known = {name if name.startswith("/") else f"/{name}" for name in recorded_topics(preparation.settings)}
    assert names - known == {"/planner/markers"}  # for RViz alone
    path = folder / RECORDING
    with AnyReader([path]) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        assert all(connection.ext.offered_qos_profiles for connection in reader.connections)
        decoded = [
            (connection.topic, came, stamp_of(reader.deserialize(data, connection.msgtype)))
            for connection, came, data in reader.messages()
        ]
    assert counts.keys() >= ALWAYS
    assert len(decoded) == sum(counts.values())
    # one reader gives them as they were written, the other by time
    again = [(topic, came, stamp_of(message)) for topic, came, message in messages(path, list(counts))]
    assert sorted(again) == sorted(decoded)


def stamp_of(message) -> tuple[int, int]:
    """Its stamp, seconds and nanoseconds; (0, 0) where it has none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return (stamp.sec, stamp.nanosec) if stamp is not None else (0, 0)


def test_it_says_what_the_run_was(ran):
    folder, _, preparation, _ = ran
    path = folder / RECORDING
    copy = folder / "copy.yaml"
    copy.write_text(attachment(path, "parameters.yaml"))
    assert read_parameters(copy) == read_parameters(folder / "parameters.yaml")
    copy.unlink()
    world = parse_text(attachment(path, "world.yaml"), "world.yaml", "world")
    assert world.name == "corridor"
    assert [corners.tolist() for corners in world.polygons] == [c.tolist() for c in preparation.world.polygons]
    about = description(path, "run")
    assert [float(value) for value in about["goal"].split()] == preparation.goal.tolist()
    assert (about["simulated"], about["namespace"]) == ("true", "/")
    assert description(path, "version").keys() >= {"collplan-core", "numpy", "numba", "python", "sources"}
