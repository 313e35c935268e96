"""Two robots in one simulated world, by bringup in this process: they cross, and see each other."""

import json
import signal

import numpy as np
import pytest
import yaml
from bringup_process import SLOWLY, Run, wait_for

from collplan_core.warm_up import warm_up
from collplan_core.worlds import load_world
from collplan_ros.bringup.failures import StartError
from collplan_ros.bringup.main import main, run_robots
from collplan_ros.bringup.options import parse
from collplan_ros.messages.mover_reading import movers_from_markers
from collplan_ros.messages.raw_reading import state_from_bytes
from collplan_ros.messages.reading import scan_from_message
from collplan_ros.run.reader import content, raw_messages
from collplan_ros.run.writer import RECORDING
from played_folders import recording_in

WORLD = {"name": "room", "bounds": [0.0, 0.0, 2.4, 1.4], "walled": True, "start": [0.4, 0.7], "goal": [2.0, 0.7]}
SENT = ["mocap/odom", "scan", "plan", "cmd_vel", "ground_truth/odom", "ground_truth/movers"]


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    path = tmp_path_factory.mktemp("world") / "room.yaml"
    path.write_text(yaml.safe_dump({key: value for key, value in WORLD.items() if key != "name"}))
    return path


@pytest.fixture(scope="module")
def crossed(room, tmp_path_factory):
    """Results of two runs with equal seeds, each of two robots that drive at each other."""
    warm_up()
    folder = tmp_path_factory.mktemp("runs")
    asked = ["--world", str(room), "--strategy", "avoid", "--robots", "2", "--out"]
    return [run_robots(parse([*asked, str(folder / name)])) for name in ("one", "two")]


def of(result, topic):
    """Messages on a topic of a run, in order."""
    return [content(each) for each in raw_messages(result.folder / RECORDING, [topic])]


def truth_of(result):
    """The true states by their stamps."""
    states = (state_from_bytes(raw, "map", "base_link") for raw in of(result, "ground_truth/odom"))
    return {state.stamp: state for state in states}


def test_both_end_at_their_goals_each_with_its_own_folder(crossed):
    for k, result in enumerate(crossed[0], 1):
        assert (result.outcome, result.exit_code) == ("reached", 0), result.message
        assert result.folder.parent.name == f"robot{k}"
        assert "--robots 2" in result.summary["repeat"]
        assert f"/robot1/{crossed[0][0].folder.name}/" in result.summary["repeat"]
        assert "--goal 2.0 0.7" in result.summary["repeat"]
    for result, (start, goal) in zip(crossed[0], ((0.4, 2.0), (2.0, 0.4)), strict=True):
        x = [state.position[0] for state in truth_of(result).values()]
        assert abs(x[0] - start) < 0.1
        assert min(abs(np.array(x) - goal)) < 0.15


def test_each_is_a_mover_for_the_other_and_in_its_scans(crossed):
    for result, other in (crossed[0], crossed[0][::-1]):
        own, others, seen = truth_of(result), truth_of(other), 0
        for message in of(result, "ground_truth/movers"):
            stamp, ((*place, radius),) = movers_from_markers(message, "map")
            if stamp in others:
                assert [*others[stamp].position, *others[stamp].velocity] == pytest.approx(place, abs=1e-6)
                # a step of the physics is as deep as bodies that hit get into each other
                assert np.hypot(*(own[stamp].position - others[stamp].position)) > 2.0 * radius - 0.005
        for message in of(result, "scan"):
            scan = scan_from_message(message, "base_link")
            if scan.stamp in own and scan.stamp in others:
                place = own[scan.stamp].position
                gap = np.hypot(*(place - others[scan.stamp].position)) - radius
                if gap < min(*place, *(WORLD["bounds"][2:] - place)) - 0.1:
                    assert scan.ranges.min() == pytest.approx(gap, abs=0.02)
                    seen += 1
        assert seen > 0


def test_equal_seeds_give_equal_runs_bit_by_bit(crossed):
    for one, two in zip(*crossed, strict=True):
        for topic in SENT:
            sent = [[each.data for each in raw_messages(result.folder / RECORDING, [topic])] for result in (one, two)]
            assert sent[0], topic
            assert sent[0] == sent[1], topic


def test_the_page_of_one_shows_the_other_as_what_moves(crossed):
    result, _ = crossed[0]
    frames = recording_in((result.folder / "run.html").read_text())["frames"]
    shown = [frame["movers"]["at"] for frame in frames if "movers" in frame]
    assert len(shown) > 20
    assert all(len(at) == 5 for at in shown)
    # from the goal towards the start
    assert shown[0][0] > 1900
    assert shown[-1][0] < 600


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["--robots", "3"], "--robots: got 3, expected 1 or 2"),
        (["--processes"], "--robots: got --processes, expected simulated robots"),
        (["--robot", "emulator"], "--robots: got --robot emulator, expected simulated robots"),
        (["--check"], "--robots: got --check, expected simulated robots"),
        (["--namespace", "lab"], "--robots: got --namespace /lab, expected none"),
        (["--keep", "lab.yaml"], "--keep: got lab.yaml, expected none with --robots"),
        (["--engine", "mujoco"], "simulator.engine: got mujoco, expected pymunk with --robots"),
        (["--goal", "0.5", "0.7"], "--robots: start and goal are 0.10 m apart, expected 3 radii"),
    ],
)
def test_what_several_robots_cannot_have_is_refused_before_any_starts(room, tmp_path, capsys, asked, said):
    pytest.importorskip("mujoco", reason="MuJoCo needs Python 3.11")
    given = ["--world", str(room), "--out", str(tmp_path / "runs"), "--robots", "2", *asked]
    assert main(given) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "runs").exists()


@pytest.mark.soak
def test_ctrl_c_ends_both_and_each_run_is_whole(room, tmp_path):
    with Run(tmp_path / "runs", "--world", str(room), "--robots", "2", "--again", *SLOWLY) as run:
        wait_for(run.moving)
        run.process.send_signal(signal.SIGINT)
        assert run.end() == 0, run.text
    for name in ("robot1", "robot2"):
        assert f"{name}: stopped by Ctrl-C" in run.text
        summary = json.loads((run.out / name / "latest" / "summary.json").read_text())
        assert summary["outcome"] == "interrupted"


def test_movers_and_robots_are_not_in_one_world_yet(room, tmp_path):
    path = tmp_path / "moved.yaml"
    mover = {"radius": 0.1, "way": [[1.2, 0.2]], "speed": 0.5}
    path.write_text(yaml.safe_dump({**yaml.safe_load(room.read_text()), "movers": [mover]}))
    assert len(load_world(str(path)).movers) == 1
    with pytest.raises(StartError, match=r"movers: got 1, expected none with --robots"):
        run_robots(parse(["--world", str(path), "--robots", "2", "--out", str(tmp_path / "runs")]))
