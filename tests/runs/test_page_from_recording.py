"""run.html of a run with run.mcap: what was thought and said is in it, at the time when it came."""

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray

from collplan_core.plan import Candidates
from collplan_ros.messages.mover_markers import movers_to_markers
from collplan_ros.messages.planner_clouds import compared_to_message, seen_to_message
from collplan_ros.run.page import write_run_page
from collplan_ros.run.result_files import mover_places
from collplan_ros.run.writer import RECORDING
from made_runs import EPOCH
from played_folders import newest, played_folder, recording_in, status

ZERO = 0.15
SQUARE = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 0.4], [0.0, 0.4]])
LAYERS = {
    "free_space": SQUARE,
    "frontiers": SQUARE[:2],
    "predicted": SQUARE[1:3],
    "remembered": SQUARE[2:],
    "inferred": SQUARE[::3],
}


def sent_in_a_run():
    candidates = Candidates(SQUARE, 0.1 * SQUARE, np.array([4.0, 3.0, 2.0, 1.0]), terms={"risk": np.arange(4.0)})
    rollouts = Candidates(SQUARE, 0.1 * SQUARE, np.ones(4), paths=(SQUARE, 2 * SQUARE), path_costs=(7.0, 5.0))
    yield "planner/seen", 0.3, seen_to_message(LAYERS, EPOCH + 0.25, "map")
    yield "planner/compared", 0.3, compared_to_message(candidates, EPOCH + 0.25, "map")
    yield "planner/compared", 0.6, compared_to_message(rollouts, EPOCH + 0.55, "map")
    costs = status("planner", b"\0", "", planning_time_ms="12.5", strategy="bounce", time="3.25")
    yield "planner/costs", 0.4, DiagnosticArray(status=[costs])
    doing = {"maneuver": "free_space", "reason": "free space", "plan_stamp": "1.0"}
    yield "controller/state", 0.5, status("/controller_node", b"\0", "", **doing)
    yield "/diagnostics", 1.0, DiagnosticArray(status=[status("/robot1/mocap_node", b"\1", "<b>late</b>", poses="12")])
    yield "/diagnostics", 1.0, DiagnosticArray(status=[status("/robot2/mocap_node", b"\2", "another robot's")])


MOVER = np.array([[0.4, 0.2, -0.5, 0.25, 0.12]])


def movers_in_a_run():
    """Topic, time of the run [s] and message: a true mover, which the planner has found for a while."""
    for time in (0.2, 0.4, 0.6):
        yield "ground_truth/movers", time, movers_to_markers(EPOCH + time, MOVER, "map")
    yield "movers", 0.45, movers_to_markers(EPOCH + 0.4, MOVER, "map")
    yield "movers", 0.65, movers_to_markers(EPOCH + 0.6, np.zeros((0, 5)), "map")


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    said = [(77.0 + time, topic, message) for topic, time, message in [*sent_in_a_run(), *movers_in_a_run()]]
    folder = played_folder(tmp_path_factory.mktemp("runs"), strategy="bounce", said=said, namespace="/robot1")
    return recording_in(write_run_page(folder).read_text())


def test_what_the_planner_saw_and_remembered_is_shown_from_when_it_came(recording):
    assert recording["notes"] == []
    frames = recording["frames"]
    for part, layer in (("free", "free_space"), ("remembered", "remembered"), ("inferred", "inferred")):
        (shown,) = (frame for frame in frames if part in frame)
        assert shown["t"] == pytest.approx(0.3 - ZERO, abs=0.05)
        assert shown[part] == np.rint(1e3 * LAYERS[layer]).astype(int).ravel().tolist()


def test_movers_are_shown_as_they_are_and_as_the_planner_has_found_them(recording):
    frames = recording["frames"]
    seen = [400, 200, -500, 250, 120]
    assert newest(frames, "movers", 0.5 - ZERO) == {"stamp": pytest.approx(0.4 - ZERO, abs=0.011), "at": seen}
    assert newest(frames, "found", 0.5 - ZERO) == {"stamp": pytest.approx(0.4 - ZERO, abs=0.011), "at": seen}
    assert newest(frames, "movers", 9.0)["at"] == seen
    assert newest(frames, "found", 9.0)["at"] == []
    assert not any("found" in frame for frame in frames if frame["t"] < 0.4 - ZERO)


def test_the_picture_has_the_places_of_movers_half_a_second_apart(tmp_path):
    said = []
    for time in (0.2, 0.4, 0.6, 0.75, 1.5):
        rows = np.array([[time, 0.2, 1.0, 0.0, 0.12], [2.0, -time, 0.0, -1.0, 0.1]])
        said.append((77.0 + time, "ground_truth/movers", movers_to_markers(EPOCH + time, rows, "map")))
    recording = played_folder(tmp_path, said=said) / RECORDING
    first, second = mover_places(recording, "map")
    np.testing.assert_allclose(first, [[0.2, 0.2, 0.12], [0.75, 0.2, 0.12], [1.5, 0.2, 0.12]], atol=1e-6)
    np.testing.assert_allclose(second, [[2.0, -0.2, 0.1], [2.0, -0.75, 0.1], [2.0, -1.5, 0.1]], atol=1e-6)
    assert mover_places(tmp_path / RECORDING, "map") == []


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


def test_what_nodes_of_this_robot_said_is_shown(recording):
    (mocap,) = newest(recording["frames"], "nodes", 9.0)
    assert (mocap["name"], mocap["message"], mocap["values"]) == ("/robot1/mocap_node", "<b>late</b>", {"poses": "12"})
