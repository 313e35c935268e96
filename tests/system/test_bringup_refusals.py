"""What bringup refuses before anything starts, and what it says when the graph does not come up."""

import json
import os
import socket
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from bringup_process import wait_for
from rclpy.context import Context
from rclpy.node import Node

from collplan_ros.bringup import preparation, processes
from collplan_ros.bringup.ending import NodeDied
from collplan_ros.bringup.main import main
from collplan_ros.bringup.options import Options
from collplan_ros.bringup.processes import NodeLogs, Processes
from collplan_ros.node_kit.reachability import RANGE, environment_set

WORLD = "bounds: [0, 0, 2, 1]\nwalled: true\npolygons:\n  - [[0.8, 0], [1.0, 0], [1.0, 1], [0.8, 1]]\n"


def written(path: Path, group: str) -> str:
    path.write_text(f"/**:\n  ros__parameters:\n    {group}\n")
    return str(path)


def test_what_cannot_be_done_is_one_line_and_exit_code_2_before_anything_starts(tmp_path, capsys):
    (tmp_path / "split.yaml").write_text(WORLD + "start: [0.3, 0.5]\n")
    on_start = "start: [0.3, 0.5]\ngoal: [0.6, 0.5]\nmovers:\n  - {radius: 0.1, way: [[0.4, 0.5]], speed: 1}\n"
    (tmp_path / "moved.yaml").write_text(WORLD + on_start)
    (tmp_path / "file").write_text("")
    split = ["--world", str(tmp_path / "split.yaml")]
    known = written(tmp_path / "c.yaml", "{trial: {known_map: true}}")
    real = ["--robot", "serial:/dev/null", "--world", "corridor", "--goal", "2.0", "0.4", "--network", "local"]
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        for arguments, expected in (
            (["--strategy", "fast"], "planner.strategy: got 'fast', expected one of harness"),
            ([*split, "--goal", "1.5", "0.5"], "cannot be reached"),
            (["--world", str(tmp_path / "moved.yaml")], "[0.4, 0.5] is 0.10 m from the robot's start"),
            (["--params", "missing.yaml"], "missing.yaml"),
            (["--strategy", "bounce", "--params", known], "trial.known_map: got True, expected False"),
            (["--view", "--params", written(tmp_path / "d.yaml", f"view: {{port: {port}}}")], f"127.0.0.1:{port}"),
            ([*real, "--again"], "--again: got --robot serial:/dev/null"),
        ):
            assert main([*arguments, "--out", str(tmp_path / "runs")]) == 2, arguments
            error = capsys.readouterr().err
            assert expected in error
            assert error.startswith("bringup: ")
            assert len(error.splitlines()) == 1, error
    assert not (tmp_path / "runs").exists()
    assert main(["--out", str(tmp_path / "file")]) == 2
    assert "is a file" in capsys.readouterr().err
    for arguments, expected in (
        (["--robot", "tank"], "--robot"),
        (["--check", "--yes"], "--check: no longer an option, inspect --live 60 takes its place"),
    ):
        with pytest.raises(SystemExit, match="2"):
            main(arguments)
        assert expected in capsys.readouterr().err


def test_a_real_lidar_needs_no_lidar_node_and_for_a_real_robot_no_world(tmp_path, monkeypatch):
    monkeypatch.setattr(preparation, "find_executable", lambda name: name)
    real = Options(robot="serial:/dev/null", network="subnet", goal=(1.0, 0.5), scan="real")
    prepared = preparation.prepare(real)
    assert "lidar_node" not in prepared.programs
    assert (prepared.world.name, prepared.settings.lidar.world, prepared.settings.simulator.world) == ("unknown",) * 3
    with pytest.raises(preparation.StartError, match="missing: --world"):
        preparation.prepare(replace(real, scan="sim"))
    simulated = preparation.prepare(Options(scan="real"))
    assert (simulated.world.name, "lidar_node" in simulated.programs) == ("corridor", False)
    # a world of the parameter file was another run's
    (tmp_path / "old.yaml").write_text("/**:\n  ros__parameters:\n    lidar.world: slalom\n")
    assert preparation.prepare(replace(real, params=tmp_path / "old.yaml")).world.name == "unknown"
    assert preparation.prepare(replace(real, world="slalom")).world.name == "slalom"
    # a base stops at its goal, unless something says otherwise
    passing = tmp_path / "passing.yaml"
    passing.write_text("/**:\n  ros__parameters:\n    planner.stop_at_goal: false\n")
    base = replace(real, robot="base:/cmd_vel")
    assert preparation.prepare(base).settings.planner.stop_at_goal
    for other in (replace(base, params=passing), real, Options()):
        assert not preparation.prepare(other).settings.planner.stop_at_goal


def test_options_outrank_the_parameter_file_and_the_file_the_defaults(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(
        "/**:\n  ros__parameters:\n    planner: {strategy: low_risk}\n    simulator: {seed: 5, world: slalom}\n"
    )
    prepared = preparation.prepare(Options(params=file, seed=7))
    assert prepared.settings.planner.strategy == "low_risk"
    assert (prepared.settings.simulator.seed, prepared.world.name) == (7, "slalom")
    assert prepared.network == "local"


def test_poses_that_repeat_are_accepted_where_it_simulates_without_noise(tmp_path):
    for simulator, mocap, accepted in (
        ({"mocap_noise": 0.0}, {}, True),
        ({"noise": 0.0}, {"accept_frozen": False}, False),
    ):
        path = tmp_path / "parameters.yaml"
        path.write_text(json.dumps({"/**": {"ros__parameters": {"simulator": simulator, "mocap": mocap}}}))
        assert preparation.prepare(Options(params=path)).settings.mocap.accept_frozen is accepted, (simulator, mocap)


def test_a_second_graph_of_a_robot_that_is_not_simulated_is_refused(tmp_path, capsys):
    robot = ["--robot", "base:/cmd_vel", "--goal", "1", "1", "--scan", "real", "--network", "local"]
    for by_hand, namespace in ((True, "/"), (False, "/robot1")):
        context = Context()
        with environment_set({RANGE: "LOCALHOST"} if by_hand else {}):
            context.init()
        other = Node("planner_node", context=context, namespace=namespace)
        try:
            assert main([*robot, "--out", str(tmp_path), "--namespace", namespace]) == 2
        finally:
            other.destroy_node()
            context.shutdown()
        assert f"planner_node already in domain {os.environ['ROS_DOMAIN_ID']}" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_node_that_ignores_sigterm_is_killed_the_first_one_goes_first_and_a_device_last(tmp_path, monkeypatch):
    monkeypatch.setattr(processes, "STOP_PATIENCE", 1.0)
    program = "import signal, sys, time; signal.signal(signal.SIGTERM, {}); print('up', flush=True); time.sleep(60)"
    stubborn, polite = program.format("signal.SIG_IGN"), program.format("lambda *_: sys.exit(print(time.time()))")
    nodes = Processes(NodeLogs(tmp_path))
    for name, code in (("device", polite), ("other", polite), ("stubborn", stubborn), ("controller", polite)):
        nodes.start(name, [sys.executable, "-c", code])
    wait_for(lambda: all((tmp_path / f"{name}.log").read_text() for name in nodes.pids))
    nodes.stop(["controller"])
    assert nodes.stop_all(("device",)) == ["stubborn"]
    orderly = ("other", "controller", "device")
    ended = {name: float((tmp_path / f"{name}.log").read_text().split()[1]) for name in orderly}
    assert sorted(ended, key=ended.__getitem__) == ["controller", "other", "device"]
    with pytest.raises(NodeDied, match=r"^stubborn was killed by SIGKILL$"):
        nodes.check([].append, dict.fromkeys(orderly, ""))
