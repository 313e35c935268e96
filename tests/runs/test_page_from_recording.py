"""run.html of a run with run.mcap: what was thought and said is in it, at the time when it came."""

import json

import numpy as np
import pytest

pytest.importorskip("rclpy")

from collplan_ros.run.record_reading import RECORD
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.serialization import serialize_message

from collplan_core.plan import Candidates
from collplan_ros.messages.planner_clouds import compared_to_message, seen_to_message
from collplan_ros.run.description import RUN
from collplan_ros.run.page import write_run_page
from collplan_ros.run.page.run_frames import PERIOD
from collplan_ros.run.schemas import schema_text, type_name
from collplan_ros.run.writer import RECORDING, RecordingFile
from made_runs import AHEAD, EPOCH
from played_folders import newest, played_folder, recording_in

ZERO = 0.15
SQUARE = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 0.4], [0.0, 0.4]])
LAYERS = {
    "free_space": SQUARE,
    "frontiers": SQUARE[:2],
    "predicted": SQUARE[1:3],
    "remembered": SQUARE[2:],
    "inferred": SQUARE[::3],
}


def status(name, level, message, **values):
    pairs = [KeyValue(key=key, value=value) for key, value in values.items()]
    return DiagnosticStatus(name=name, level=level, message=message, values=pairs)


def sent_in_a_run():
    """Topic, time of the run [s] and message."""
    candidates = Candidates(SQUARE, 0.1 * SQUARE, np.array([4.0, 3.0, 2.0, 1.0]), terms={"risk": np.arange(4.0)})
    rollouts = Candidates(SQUARE, 0.1 * SQUARE, np.ones(4), paths=(SQUARE, 2 * SQUARE), path_costs=(7.0, 5.0))
    costs = status("planner", b"\0", "", planning_time_ms="12.5", strategy="bounce", time="3.25", clearance="0.5")
    doing = {"maneuver": "free_space", "activity": "bounce", "reason": "", "plan_stamp": "1.0"}
    yield "planner/seen", 0.3, seen_to_message(LAYERS, EPOCH + 0.25, "map")
    yield "planner/compared", 0.3, compared_to_message(candidates, EPOCH + 0.25, "map")
    yield "planner/compared", 0.6, compared_to_message(rollouts, EPOCH + 0.55, "map")
    yield "planner/costs", 0.4, DiagnosticArray(status=[costs])
    yield "controller/state", 0.5, status("/controller_node", b"\0", "", **doing)
    stopped = doing | {"activity": "stopped", "reason": "old"}
    yield "controller/state", 1.5, status("/controller_node", b"\1", "", **stopped)
    yield "robot/state", 0.5, status("/simulator_node", b"\0", "", state="free", reason="")
    yield "/diagnostics", 0.2, DiagnosticArray(status=[status("/robot1/planner_node", b"\0", "plans")])
    yield "/diagnostics", 1.0, DiagnosticArray(status=[status("/robot1/mocap_node", b"\1", "<b>late</b>", poses="12")])
    yield "/diagnostics", 1.0, DiagnosticArray(status=[status("/robot2/mocap_node", b"\2", "another robot's")])


def played(parent, step=0.0, when=0.0):
    """What the page is given of a run in which the wall clock was set by `step` [s] `when` of the run [s]."""
    folder = played_folder(parent, strategy="bounce")
    with (folder / RECORD).open("a") as record:
        record.write(json.dumps(["wall_clock", 77.0 + when, AHEAD + step]) + "\n")
    file = RecordingFile(folder / RECORDING)
    file.describe(RUN, {"goal": "0.0 0.1", "simulated": "true", "namespace": "/robot1"})
    for number, (topic, time, message) in enumerate(sorted(sent_in_a_run(), key=lambda row: row[1]), 1):
        kind = type_name(type(message))
        name = topic if topic.startswith("/") else f"/robot1/{topic}"
        channel = file.channel(name, kind, schema_text(kind), {})
        came = round(1e9 * (77.0 + time + AHEAD + (step if time >= when else 0.0)))
        file.write(channel, serialize_message(message), came, came, number)
    file.finish()
    return recording_in(write_run_page(folder).read_text())


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return played(tmp_path_factory.mktemp("runs"))


def test_what_the_planner_saw_and_remembered_is_shown_from_when_it_came(recording):
    assert recording["notes"] == []
    frames = recording["frames"]
    for part, layer in (("free", "free_space"), ("remembered", "remembered"), ("inferred", "inferred")):
        (shown,) = (frame for frame in frames if part in frame)
        assert shown["t"] == pytest.approx(0.3 - ZERO, abs=0.05)
        assert shown[part] == np.rint(1e3 * LAYERS[layer]).astype(int).ravel().tolist()


def test_what_was_compared_is_shown_with_its_terms(recording):
    frames = recording["frames"]
    first = newest(frames, "candidates", 0.5 - ZERO)
    assert first["terms"]["total"] == [1.0, 2.0, 3.0, 4.0]
    assert first["terms"]["risk"] == [3.0, 2.0, 1.0, 0.0]
    assert first["at"][:4] == [0, 400, 0, 40]
    assert newest(frames, "rollouts", 0.5 - ZERO) == []
    rollouts = newest(frames, "rollouts", 9.0)
    assert [each["cost"] for each in rollouts] == [5.0, 7.0]
    assert rollouts[0]["path"] == (2000 * SQUARE).astype(int).ravel().tolist()
    assert newest(frames, "candidates", 9.0)["at"] == []


def test_what_nodes_said_is_shown(recording):
    frames = recording["frames"]
    (costs,) = (frame["costs"] for frame in frames if "costs" in frame)
    assert costs["terms"] == {"time": 3.25, "clearance": 0.5}
    assert newest(frames, "doing", 0.6 - ZERO)["activity"] == "bounce"
    last = newest(frames, "doing", 9.0)
    assert (last["activity"], last["reason"], last["warn"]) == ("stopped", "old", True)
    assert newest(frames, "hold", 9.0) == {"state": "free", "message": ""}
    mocap, planner = newest(frames, "nodes", 9.0)
    assert (mocap["name"], mocap["level"], mocap["message"]) == ("/robot1/mocap_node", 1, "<b>late</b>")
    assert mocap["values"] == {"poses": "12"}
    assert (planner["name"], planner["silent"]) == ("/robot1/planner_node", False)


def test_a_wall_clock_that_is_set_in_the_run_changes_nothing(recording, tmp_path):
    stepped = played(tmp_path, -3600.0, when=0.45)
    for part in ("free", "candidates", "rollouts", "costs", "doing", "hold"):
        before, after = ([(f["t"], f[part]) for f in each["frames"] if part in f] for each in (recording, stepped))
        assert [value for _, value in after] == [value for _, value in before]
        assert [t for t, _ in after] == pytest.approx([t for t, _ in before], abs=1.1 * PERIOD)
