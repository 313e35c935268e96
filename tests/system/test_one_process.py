"""The simulated robot and its nodes in bringup's process: equal runs, and a node that fails is named."""

import csv
import time

import pytest

from collplan_core.parameters.file import read_parameters
from collplan_core.warm_up import warm_up
from collplan_ros.bringup import one_process
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import parse
from collplan_ros.nodes.controller_node import ControllerNode
from collplan_ros.nodes.planner_node import PlannerNode
from collplan_ros.run.reader import raw_messages
from collplan_ros.run.writer import RECORDING

SENT = ["mocap/odom", "scan", "plan", "planner/trajectory", "cmd_vel", "ground_truth/odom", "impact/contact"]

FILES = {"summary.json", "trajectory.csv", "impacts.csv", "trajectory.png", "run.html", "parameters.yaml"}
FILES |= {"run.mcap", "log"}


@pytest.fixture
def driven(tmp_path):
    warm_up()
    asked = ["--world", "u:17", "--strategy", "bounce", "--seed", "3", "--out"]
    return lambda name, *options: run(parse([*asked, str(tmp_path / name), *options]))


def test_equal_seeds_give_equal_runs_bit_by_bit_and_each_a_complete_folder(driven):
    runs = driven("one"), driven("two", "--no-pictures")
    assert_complete(runs[0])
    assert all(one.summary["reached"] for one in runs)
    sent = [[(each.topic, each.data) for each in raw_messages(one.folder / RECORDING, SENT)] for one in runs]
    for topic in SENT:
        of_topic = [[data for name, data in each if name == topic] for each in sent]
        assert of_topic[0], topic
        assert of_topic[0] == of_topic[1], topic
    for name in ("trajectory.csv", "impacts.csv"):
        assert (runs[0].folder / name).read_bytes() == (runs[1].folder / name).read_bytes()


def assert_complete(result):
    folder, summary = result.folder, result.summary
    assert {entry.name for entry in folder.iterdir()} == FILES
    assert summary.items() >= {"reached": True, "world": "u:17", "strategy": "bounce", "seed": 3}.items()
    assert summary["path_length_source"] == "ground_truth"
    rows = list(csv.DictReader((folder / "trajectory.csv").open()))
    assert summary["arrival_time_s"] == pytest.approx(float(rows[-1]["t"]), abs=1e-5)
    assert len((folder / "impacts.csv").read_text().splitlines()) == 1 + summary["impacts"]
    assert read_parameters(folder / "parameters.yaml")["simulator.seed"] == 3


def raises(*_):
    raise ZeroDivisionError("in a callback")


def hangs(*_):
    while True:
        time.sleep(0.01)


@pytest.mark.parametrize(
    ("node", "callback", "fault", "said"),
    [
        (PlannerNode, "_on_pose", raises, "planner_node ended by ZeroDivisionError: in a callback"),
        (ControllerNode, "_on_timer", hangs, "controller_node hangs"),
        (ControllerNode, "_make_inputs", raises, "controller_node ended by ZeroDivisionError: in a callback"),
    ],
)
def test_a_node_that_raises_or_hangs_ends_the_run_by_its_name(driven, monkeypatch, capsys, node, callback, fault, said):
    monkeypatch.setattr(one_process, "LOOK_PERIOD", 0.1)
    monkeypatch.setattr(node, callback, fault)
    result = driven("runs", "--no-pictures")
    assert (result.outcome, result.exit_code, result.message) == ("node_died", 3, said)
    log = (result.folder / "log" / f"{said.split()[0]}.log").read_text()
    assert f"in {fault.__name__}" in log
    assert "last lines of" in capsys.readouterr().out
