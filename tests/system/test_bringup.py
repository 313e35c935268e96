"""bringup as a process: it reaches the goal, and however it ends no process stays behind."""

import csv
import io
import os
import signal
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from bringup_process import NODES, Run, nodes_of, wait_for

from collplan_core.parameters import Settings
from collplan_core.parameters.file import write_values
from collplan_core.warm_up import warm_up
from collplan_ros.bringup.graph import Graph
from collplan_ros.bringup.main import run
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.progress import Progress
from collplan_ros.recording.reading import description, raw_messages
from collplan_ros.recording.recording_file import RECORDING, RecordingFile

QUESTION = {"world", "strategy", "seed", "simulated", "repeat", "assumed"}
FIGURES = {"reached", "outcome", "arrival_time_s", "path_length_m", "path_length_source", "impacts"}
KEYS = QUESTION | FIGURES | {"plan_time_ms", "control_period_ms", "candidates", "maneuvers"}
FILES = {
    "summary.json",
    "trajectory.csv",
    "impacts.csv",
    "trajectory.png",
    "run.gif",
    "run.html",
    "parameters.yaml",
    "record.jsonl",
    "run.mcap",
    "log",
}


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    """Four nodes that compile at once are slow; here they find it done."""
    warm_up()


def killed_run(folder: Path) -> Path:
    """The recording of a run whose bringup was killed."""
    folder.mkdir(parents=True)
    recording = RecordingFile(folder / RECORDING)
    recording.describe("run", {"goal": "1.0 2.0"})
    recording.flush()
    content = (folder / RECORDING).read_bytes()
    recording.finish()
    (folder / RECORDING).write_bytes(content)
    return folder / RECORDING


def test_the_goal_is_reached_and_the_folder_is_complete(tmp_path):
    earlier = killed_run(tmp_path / "runs" / "2000-01-01_00-00-00")
    with Run(tmp_path / "runs", "--seed", "3") as run:
        assert run.end() == 0, run.text
    assert nodes_of(run.out) == {}
    assert {entry.name for entry in (run.out / "latest").iterdir()} == FILES
    assert f"completing {earlier.parent} ...\n{earlier}: had no end; completed" in run.text
    assert "writing the results ..." in run.text
    assert description(earlier, "run") == {"goal": "1.0 2.0"}
    summary = run.summary()
    assert summary.keys() >= KEYS
    assert (summary["reached"], summary["world"], summary["strategy"], summary["seed"]) == (
        True,
        "corridor",
        "harness",
        3,
    )
    assert summary["path_length_source"] == "ground_truth"
    assert summary["control_period_ms"]["n"] > 20
    assert summary["candidates"]["before_pruning_mean"] >= summary["candidates"]["mean"] > 0
    rows = list(csv.DictReader((run.out / "latest" / "trajectory.csv").open()))
    stamps = [float(row["t"]) for row in rows]
    steps = sorted(b - a for a, b in pairwise(stamps))
    assert steps[len(steps) // 2] == pytest.approx(0.01, abs=1e-3)
    assert summary["arrival_time_s"] == pytest.approx(stamps[-1], abs=1e-5)
    first = next(t for t, row in zip(stamps, rows, strict=True) if abs(float(row["cmd_vx"])) > 0.0)
    assert first == pytest.approx(0.0, abs=0.3)
    assert len((run.out / "latest" / "impacts.csv").read_text().splitlines()) == 1 + summary["impacts"]
    from collplan_core.parameters.file import read_parameters

    used = read_parameters(run.out / "latest" / "parameters.yaml")
    assert used["simulator.seed"] == 3


@pytest.mark.soak
def test_a_bringup_that_falls_behind_tells_the_run_as_it_was(tmp_path, monkeypatch):
    """For 9 s it takes no message, while the robot arrives and stands at its goal longer than trial.stuck_time."""
    lateness = []
    step = Graph.step

    def falls_behind(self):
        moved = self.recorder.time_zero is not None
        if moved and not lateness:
            time.sleep(9.0)
        step(self)
        if moved:
            lateness.append(self.recorder.lateness)

    monkeypatch.setattr(Graph, "step", falls_behind)
    said = io.StringIO()
    result = run(Options(seed=3, out=tmp_path / "runs", pictures=False), Progress(said))
    assert max(lateness) > 5.0
    assert (result.outcome, result.exit_code) == ("reached", 0), said.getvalue()
    rows = list(csv.DictReader((result.folder / "trajectory.csv").open()))
    offsets = np.array([[float(row[axis]) for axis in "xy"] for row in rows]) - result.summary["goal"]
    within = np.hypot(*offsets.T) <= Settings().planner.goal_tolerance
    assert np.flatnonzero(within).tolist() == [len(rows) - 1]
    assert float(rows[-1]["t"]) == pytest.approx(result.summary["arrival_time_s"], abs=1e-5)
    assert result.summary["path_length_m"] > 1.5
    impacts = [float(row["t"]) for row in csv.DictReader((result.folder / "impacts.csv").open())]
    assert all(0.0 <= t <= result.summary["arrival_time_s"] for t in impacts)
    assert said.getvalue().count("   0.0 s ") <= 1


@pytest.mark.soak
def test_two_robots_in_a_domain_reach_their_goals_each_by_its_own_clock(tmp_path):
    """Both in simulated time, one half as fast as the other: were /clock shared, neither would know the time.

    Two graphs in real time beside that of another test are more than two cores can do in time.
    """

    def at_speed(factor: float) -> list[str]:
        path = tmp_path / f"{factor}.yaml"
        write_values({"simulator.speed_factor": factor}, path)
        return ["--no-pictures", "--world", "slalom", "--params", str(path)]

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


@pytest.mark.parametrize(
    "number", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.soak)], ids=["ctrl_c", "sigterm"]
)
def test_a_signal_stops_everything_in_order(tmp_path, number):
    with Run(tmp_path / "runs", "--timeout", "60", "--no-pictures") as run:
        wait_for(run.moving)
        assert nodes_of(run.out).keys() == NODES
        run.process.send_signal(number)
        assert run.end() == 128 + number, run.text
    assert nodes_of(run.out) == {}
    assert run.summary()["outcome"] == "interrupted"
    said = "".join(log.read_text() for log in (run.out / "latest" / "log").iterdir())
    assert "Traceback" not in said + run.text
    assert "killed" not in run.text


@pytest.mark.parametrize(
    "node", [name if name == "planner_node" else pytest.param(name, marks=pytest.mark.soak) for name in sorted(NODES)]
)
def test_a_node_that_dies_is_named_and_ends_the_run(tmp_path, node):
    with Run(tmp_path / "runs", "--no-pictures") as run:
        wait_for(run.moving)
        os.kill(nodes_of(run.out)[node], signal.SIGKILL)
        assert run.end() == 3
    assert f"{node} was killed by SIGKILL" in run.text
    assert nodes_of(run.out) == {}
    assert run.summary()["outcome"] == "node_died"


@pytest.mark.parametrize("moment", ["starting", pytest.param("moving", marks=pytest.mark.soak)])
def test_no_node_outlives_a_killed_bringup(tmp_path, moment):
    with Run(tmp_path / "runs", "--no-pictures") as run:
        wait_for(run.moving if moment == "moving" else lambda: nodes_of(run.out))
        run.process.kill()
        run.end()
        wait_for(lambda: not nodes_of(run.out), patience=5.0)


@pytest.mark.soak
def test_no_node_outlives_a_bringup_killed_at_any_moment_of_its_start(tmp_path):
    for k in range(20):
        with Run(tmp_path / f"runs_{k}", "--no-pictures") as run:
            wait_for(lambda run=run: (run.out / "latest").is_symlink())
            time.sleep(0.004 * k)
            run.process.kill()
            run.end()
            wait_for(lambda run=run: not nodes_of(run.out), patience=5.0)
